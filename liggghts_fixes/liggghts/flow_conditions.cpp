// What drives the flow, by the values of now (script_names.h).
#include <input.h>
#include <lammps.h>
#include <variable.h>

#include <cctype>
#include <cmath>
#include <set>

#include "liggghts_fixes/liggghts/script_names.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

std::string change_of(const std::vector<double>& before, const std::vector<FlowCondition>& now) {
  for (std::size_t i = 0; i < now.size() && i < before.size(); ++i) {
    const FlowCondition& c = now[i];
    if (std::abs(c.value - before[i]) <= 1e-12 * std::abs(c.value)) continue;
    return c.formula ? c.name + " follows another formula than in the run before"
                     : c.name + " is " + brief(c.value) + " and was " + brief(before[i]) + " when the run before ended";
  }
  return "";
}

FlowCondition ScriptNames::condition(const std::string& name, const std::string& variable, double number) const {
  if (variable.empty()) return {name, number, false};
  std::string text = variable;
  if (hangs_on_step(variable)) {
    Variable* const variables = lammps_.input->variable;
    return {name, variables->compute_equal(variables->find(text.data())), false};
  }
  // It changes during runs: asked for here, a value would be one more that it draws, or not be known now.
  unsigned hash = 2166136261u;
  for (const char c : formulas(variable)) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return {name, double(hash), true};
}

std::vector<FlowCondition> ScriptNames::conditions() const {
  const FluidSettings& s = script_.settings.fluid;
  std::vector<FlowCondition> all;
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script_.names[side].size(); ++c) {
      const BoundaryCondition& condition = s.side[side][c];
      const std::string where =
          "boundary " + std::string(kSideNames[side]) + (condition.name.empty() ? "" : " patch " + condition.name);
      const ScriptedVelocity& v = script_.names[side][c].velocity;
      for (int d = 0; d < 3; ++d)
        all.push_back(this->condition(where + ", velocity in " + "xyz"[d], v.variable[d], v.number[d]));
      all.push_back({where + ", pressure", condition.pressure});
    }
  for (const BodyNames& b : script_.bodies)
    all.push_back(condition("solid " + b.name + ", blow", b.blow_variable, b.blow));
  for (int d = 0; d < 3; ++d) {
    all.push_back({std::string("flow_rate ") + "xyz"[d], s.flow_rate[d]});
    all.push_back({std::string("pressure_gradient in ") + "xyz"[d], s.pressure_gradient[d]});
  }
  all.push_back({"viscosity", s.viscosity});
  return all;
}

bool ScriptNames::drives_flow() const {
  const auto is = [&](const std::string& variable, double number) {
    // Not to be known: it may.
    return variable.empty() ? number != 0 : !hangs_on_step(variable) || largest_ahead(variable, "boundary") != 0;
  };
  const FluidSettings& s = script_.settings.fluid;
  std::set<double> pressures;
  bool periodic[3] = {false, false, false};
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script_.names[side].size(); ++c) {
      const BoundaryCondition& condition = s.side[side][c];
      const ScriptedVelocity& v = script_.names[side][c].velocity;
      for (int d = 0; d < 3; ++d)
        if (is(v.variable[d], v.number[d])) return true;
      if (condition.kind == BoundaryKind::kPressure) pressures.insert(condition.pressure);
      if (condition.kind == BoundaryKind::kPeriodic) periodic[direction(side)] = true;
    }
  for (const BodyNames& b : script_.bodies)
    if (is(b.blow_variable, b.blow)) return true;
  for (int d = 0; d < 3; ++d)
    if (periodic[d] &&
        (s.pressure_gradient[d] != 0 || s.flow_rate[d] != 0 || (!s.flow_rate_set[d] && s.initial_velocity[d] != 0)))
      return true;
  return pressures.size() > 1;
}

}  // namespace twogrid
