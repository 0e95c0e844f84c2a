#include "liggghts_fixes/liggghts/script_names.h"

#include <domain.h>
#include <input.h>
#include <lammps.h>
#include <modify.h>
#include <region.h>
#include <update.h>
#include <variable.h>

#include <cctype>
#include <cmath>
#include <set>

#include "liggghts_fixes/liggghts/region_boxes.h"
#include "liggghts_fixes/private_member.h"
#include "liggghts_fixes/script/words.h"

namespace {
PRIVATE_MEMBER(VariableData, LAMMPS_NS::Variable, char***, data);
}

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// The step is a later one, if any, while this lives.
class Later {
 public:
  Later(Update& update, long long step) : update_(update), now_(update.ntimestep) {
    if (step > 0) update_.ntimestep = step;
  }
  ~Later() { update_.ntimestep = now_; }
  Later(const Later&) = delete;
  Later& operator=(const Later&) = delete;

 private:
  Update& update_;
  bigint now_;
};

}  // namespace

double ScriptNames::equal_style(const std::string& variable, const std::string& keyword) const {
  Variable* const variables = lammps_.input->variable;
  Modify* const modify = lammps_.modify;
  std::string name = variable;
  const int v = variables->find(name.data());
  if (v < 0) refuse(keyword, "v_" + variable + ", and no variable of that name", "an equal-style variable");
  if (!variables->equalstyle(v))
    refuse(keyword, "v_" + variable + ", which is not equal-style", "an equal-style variable");
  // LIGGGHTS' list of computes that a variable may ask for exists only once a run has been set up.
  if (!in_run_) return variables->compute_equal(v);
  modify->clearstep_compute();
  double value = 0;
  {
    const Later later(*lammps_.update, later_);
    value = variables->compute_equal(v);
  }
  modify->addstep_compute(lammps_.update->ntimestep + script_.settings.every);
  return value;
}

bool ScriptNames::hangs_on_step(const std::string& variable, int depth) const {
  static const std::set<std::string> kKnown{"step",  "dt",    "ramp", "PI",    "sqrt",      "exp",     "ln",
                                            "log",   "sin",   "cos",  "tan",   "asin",      "acos",    "atan",
                                            "atan2", "floor", "ceil", "round", "vdisplace", "swiggle", "cwiggle"};
  Variable* const variables = lammps_.input->variable;
  std::string name = variable;
  const int v = variables->find(name.data());
  if (v < 0 || depth > 20) return false;
  if (!variables->equalstyle(v)) return !variables->atomstyle(v);
  const std::string formula = (variables->*member(VariableData()))[v][0];
  for (std::size_t i = 0; i < formula.size();) {
    const auto is_word = [&](std::size_t at) {
      return at < formula.size() && (std::isalnum(static_cast<unsigned char>(formula[at])) || formula[at] == '_');
    };
    if (std::isdigit(static_cast<unsigned char>(formula[i])) || formula[i] == '.') {
      std::size_t used = 1;
      try {
        std::stod(formula.substr(i), &used);
      } catch (const std::exception&) {
        return false;
      }
      i += used;
      continue;
    }
    if (!is_word(i)) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (is_word(end)) ++end;
    const std::string word = formula.substr(i, end - i);
    if (word.rfind("v_", 0) == 0 ? !hangs_on_step(word.substr(2), depth + 1) : !kKnown.count(word)) return false;
    i = end;
  }
  return true;
}

/// Of a variable and of those that it names: what they are, not their values.
std::string ScriptNames::formulas(const std::string& variable, int depth) const {
  Variable* const variables = lammps_.input->variable;
  std::string name = variable;
  const int v = variables->find(name.data());
  if (v < 0 || depth > 20) return variable;
  if (!variables->equalstyle(v)) {
    const char* const value = variables->atomstyle(v) ? nullptr : variables->retrieve(name.data());
    return variable + "=" + (value ? value : "");
  }
  const std::string formula = (variables->*member(VariableData()))[v][0];
  std::string all = formula;
  for (std::size_t i = formula.find("v_"); i != std::string::npos; i = formula.find("v_", i + 2)) {
    std::size_t end = i + 2;
    while (end < formula.size() && (std::isalnum(static_cast<unsigned char>(formula[end])) || formula[end] == '_'))
      ++end;
    all += ";" + formulas(formula.substr(i + 2, end - i - 2), depth + 1);
  }
  return all;
}

/// Of either sign; NaN: not to be known.
double ScriptNames::largest_ahead(const std::string& variable, const std::string& keyword) const {
  constexpr int kLooks = 64;
  const double now = equal_style(variable, keyword);
  if (!hangs_on_step(variable)) return NAN;
  Update& update = *lammps_.update;
  Variable* const variables = lammps_.input->variable;
  std::string name = variable;
  const int v = variables->find(name.data());
  const bigint step = update.ntimestep;
  double most = now;
  for (int i = 0; i <= kLooks; ++i) {
    update.ntimestep = update.beginstep + (update.endstep - update.beginstep) * i / kLooks;
    const double value = variables->compute_equal(v);
    if (std::abs(value) > std::abs(most)) most = value;
  }
  update.ntimestep = step;
  return most;
}

InletsAhead ScriptNames::ahead() const {
  InletsAhead all;
  for (int side = 0; side < 6; ++side)
    for (const ConditionNames& names : script_.names[side]) {
      const std::string& variable = names.velocity.variable[side / 2];
      all.side[side].push_back(variable.empty() ? names.velocity.number[side / 2]
                                                : largest_ahead(variable, std::string("boundary ") + kSideNames[side]));
    }
  for (const BodyNames& names : script_.bodies)
    all.body.push_back(
        names.blow_variable.empty() ? names.blow : largest_ahead(names.blow_variable, "solid " + names.name + " blow"));
  return all;
}

Vec3 ScriptNames::velocity_now(int side, std::size_t condition) const {
  const ScriptedVelocity& v = script_.names[side][condition].velocity;
  Vec3 u = v.number;
  for (int d = 0; d < 3; ++d) {
    if (v.variable[d].empty()) continue;
    const std::string& patch = script_.settings.fluid.side[side][condition].name;
    const std::string keyword = "boundary " + std::string(kSideNames[side]) + (patch.empty() ? "" : " patch " + patch);
    u[d] = equal_style(v.variable[d], keyword);
    if (!(u[d] >= kVelocities.least && u[d] <= kVelocities.most))
      refuse(keyword, "v_" + v.variable[d] + " = " + text(u[d]),
             "a variable with a finite velocity (m/s) at all times; " + text(kVelocities.least) + " to " +
                 text(kVelocities.most));
  }
  return u;
}

void ScriptNames::resolve() {
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script_.names[side].size(); ++c) {
      BoundaryCondition& condition = script_.settings.fluid.side[side][c];
      const ConditionNames& names = script_.names[side][c];
      condition.velocity = velocity_now(side, c);
      if (!names.velocity.is_constant()) condition.velocity_now = [this, side, c] { return velocity_now(side, c); };
      if (names.region.empty()) continue;
      std::string region = names.region;
      const int r = lammps_.domain->find_region(region.data());
      if (r < 0)
        refuse("boundary " + std::string(kSideNames[side]) + " patch " + condition.name + " region",
               names.region + ", and no region of that id", "the id of a region");
      Region* shape = lammps_.domain->regions[r];
      condition.shape.inside = [shape](const Vec3& x) { return shape->match(x[0], x[1], x[2]) != 0; };
      condition.shape.boxes = region_boxes(lammps_, *shape);
    }
}

void ScriptNames::renew(FluidSettings& fluid) const {
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script_.settings.fluid.side[side].size(); ++c) {
      BoundaryCondition& now = fluid.side[side][c];
      const BoundaryCondition& found = script_.settings.fluid.side[side][c];
      now.velocity = found.velocity;
      now.velocity_now = found.velocity_now;
      now.shape.inside = found.shape.inside;
    }
}

void ScriptNames::check_region_faces(const FineGrid& grid) {
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script_.names[side].size(); ++c) {
      const BoundaryCondition& condition = script_.settings.fluid.side[side][c];
      if (!condition.shape.inside) continue;
      const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
      std::vector<bool> faces;
      Vec3 x;
      x[d] = grid.axis[d].node(is_high(side) ? grid.axis[d].n() : 0);
      for (int j = 0; j < grid.axis[f].n(); ++j)
        for (int i = 0; i < grid.axis[e].n(); ++i) {
          x[e] = grid.axis[e].centre(i), x[f] = grid.axis[f].centre(j);
          faces.push_back(condition.shape.inside(x));
        }
      const auto known = region_faces_.try_emplace({side, c}, faces).first;
      if (known->second != faces)
        refuse("boundary " + std::string(kSideNames[side]) + " patch " + condition.name + " region",
               script_.names[side][c].region + ", which has another shape than in the fix's first run",
               "the same: a patch keeps its faces ('unfix " + id_ +
                   "' and the fix again take the new shape; the fluid then begins anew)");
    }
}

}  // namespace twogrid
