#include "liggghts_fixes/script/boundary_words.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "liggghts_fixes/script/options.h"

namespace twogrid {
namespace {

const char* const kAxis = "xyz";

const Options<BoundaryKind>& conditions() {
  static const Options<BoundaryKind> kConditions{{BoundaryKind::kSlip, "slip"},
                                                 {BoundaryKind::kNoSlip, "noslip"},
                                                 {BoundaryKind::kInlet, "inlet"},
                                                 {BoundaryKind::kPressure, "pressure"},
                                                 {BoundaryKind::kPeriodic, "periodic"}};
  return kConditions;
}

int side_of(const std::string& name) {
  for (int s = 0; s < 6; ++s)
    if (name == kSideNames[s]) return s;
  return -1;
}

ScriptedVelocity scripted_velocity(Words& words, const std::string& keyword) {
  const std::string wanted = "three velocities in m/s, numbers or v_NAME";
  ScriptedVelocity v;
  for (int d = 0; d < 3; ++d) {
    const std::string& next = words.peek();
    if (next.rfind("v_", 0) == 0 && next.size() > 2) {
      v.variable[d] = words.name(keyword, wanted).substr(2);
    } else {
      v.number[d] = words.number(keyword, wanted, kVelocities);
    }
  }
  return v;
}

/// Not so for NaN.
bool within(double value, const Range& range) {
  return value >= range.least && value <= range.most;
}

std::vector<std::array<double, 2>> read_table(const std::string& keyword, const std::string& file) {
  std::error_code e;
  std::ifstream in(std::filesystem::is_regular_file(file, e) ? file : "");  // others may have no end
  const std::string wanted = "a readable file of two columns, coordinate (m, ascending) and factor on the velocity";
  if (!in) refuse(keyword, file, wanted);
  std::vector<std::array<double, 2>> table;
  std::string line;
  while (std::getline(in, line)) {
    line.resize(std::min(line.find('#'), line.size()));
    if (line.find_first_not_of(" \t\r,") == std::string::npos) continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    char* end = nullptr;
    std::array<double, 2> row{};
    row[0] = std::strtod(line.c_str(), &end);
    char* second = end;
    row[1] = std::strtod(second, &end);
    if (end == second || !within(row[0], kCoordinates) || !within(row[1], kFactors) ||
        (!table.empty() && row[0] <= table.back()[0]))
      refuse(keyword, "the line '" + line + "' in " + file, wanted);
    table.push_back(row);
  }
  if (table.size() < 2)
    refuse(keyword, std::to_string(table.size()) + " lines in " + file, wanted + ", at least two lines");
  return table;
}

InletProfile profile(Words& words, const std::string& keyword, int normal, std::string* file) {
  InletProfile p;
  const int kind = words.one_of(keyword + " profile", {"parabolic", "table"});
  if (kind == 0) {
    p.shape = InletProfile::Shape::kParabolic;
    const std::string wanted = "the tangential directions it varies in, e.g. x or xy";
    const std::string across = words.word(keyword + " profile parabolic", wanted);
    for (char c : across) {
      const int d = c == 'x' ? 0 : c == 'y' ? 1 : c == 'z' ? 2 : -1;
      if (d < 0 || d == normal || p.across[d]) refuse(keyword + " profile parabolic", across, wanted);
      p.across[d] = true;
    }
  } else {
    p.shape = InletProfile::Shape::kTable;
    p.coordinate = words.one_of(keyword + " profile table", {"x", "y", "z"});
    if (p.coordinate == normal)
      refuse(keyword + " profile table", std::string(1, kAxis[normal]), "a direction in the plane of the side");
    *file = words.name(keyword + " profile table", "a file name");
    p.table = read_table(keyword + " profile table", *file);
  }
  return p;
}

PatchShape patch_shape(Words& words, const std::string& keyword, std::string* region) {
  PatchShape shape;
  const int kind = words.one_of(keyword, {"rect", "circle", "region"});
  if (kind == 0) {
    shape.kind = PatchShape::Kind::kRectangle;
    const std::string wanted = "four bounds in m, lo hi lo hi in the side's two directions, each lo below its hi";
    for (double& v : shape.value) v = words.number(keyword + " rect", wanted, kCoordinates);
    if (!(shape.value[0] < shape.value[1]) || !(shape.value[2] < shape.value[3]))
      refuse(
          keyword + " rect",
          text(shape.value[0]) + " " + text(shape.value[1]) + " " + text(shape.value[2]) + " " + text(shape.value[3]),
          wanted);
  } else if (kind == 1) {
    shape.kind = PatchShape::Kind::kCircle;
    shape.value[0] =
        words.number(keyword + " circle", "the centre's two coordinates (m) and a radius (m)", kCoordinates);
    shape.value[1] =
        words.number(keyword + " circle", "the centre's two coordinates (m) and a radius (m)", kCoordinates);
    shape.value[2] = words.number(keyword + " circle", "a radius above 0 (m)", kLengths);
  } else {
    shape.kind = PatchShape::Kind::kRegion;
    *region = words.name(keyword + " region", "the id of a LIGGGHTS region");
  }
  return shape;
}

std::string velocity_text(const ScriptedVelocity& v) {
  std::string s;
  for (int d = 0; d < 3; ++d) s += " " + (v.variable[d].empty() ? exact(v.number[d]) : "v_" + v.variable[d]);
  return s;
}

std::string shape_text(const PatchShape& shape, const std::string& region) {
  if (shape.kind == PatchShape::Kind::kRegion) return "region " + region;
  const bool circle = shape.kind == PatchShape::Kind::kCircle;
  std::string s = circle ? "circle" : "rect";
  for (int i = 0; i < (circle ? 3 : 4); ++i) s += " " + exact(shape.value[i]);
  return s;
}

std::string profile_text(const InletProfile& p, const std::string& file) {
  if (p.shape == InletProfile::Shape::kConstant) return "";
  if (p.shape == InletProfile::Shape::kTable) return std::string(" profile table ") + kAxis[p.coordinate] + " " + file;
  std::string s = " profile parabolic ";
  for (int d = 0; d < 3; ++d)
    if (p.across[d]) s += kAxis[d];
  return s;
}

std::string one_condition(const BoundaryCondition& c, const ConditionNames& names) {
  std::string s = c.name.empty() ? "" : "patch " + c.name + " " + shape_text(c.shape, names.region) + " ";
  s += condition_word(c.kind);
  const bool moves = !names.velocity.is_constant() || names.velocity.number != Vec3{0, 0, 0};
  if (c.kind == BoundaryKind::kInlet || (c.kind == BoundaryKind::kNoSlip && moves)) s += velocity_text(names.velocity);
  if (c.kind == BoundaryKind::kInlet) s += profile_text(c.profile, names.table);
  if (c.kind == BoundaryKind::kPressure) s += " " + exact(c.pressure);
  return s;
}

}  // namespace

std::string condition_word(BoundaryKind kind) {
  return option_of(conditions(), kind).word;
}

std::string boundary_text(const Script& script) {
  std::string s;
  for (int side = 0; side < 6; ++side)
    for (std::size_t c = 0; c < script.names[side].size(); ++c)
      s += (s.empty() ? "" : "; ") + std::string(kSideNames[side]) + " " +
           one_condition(script.settings.fluid.side[side][c], script.names[side][c]);
  return s;
}

void parse_boundary(Script& script, Words& words, bool started) {
  const std::string side_word = words.word("boundary", "a side: xlo, xhi, ylo, yhi, zlo or zhi");
  const int side = side_of(side_word);
  if (side < 0) refuse("boundary", side_word, "a side: xlo, xhi, ylo, yhi, zlo or zhi");
  std::string keyword = "boundary " + side_word;

  BoundaryCondition condition;
  ConditionNames names;
  if (words.take_if("patch")) {
    condition.name = words.name(keyword + " patch", "a name and a shape: rect, circle or region");
    keyword += " patch " + condition.name;
    condition.shape = patch_shape(words, keyword, &names.region);
  }

  condition.kind = take_option(words, keyword, conditions());
  if (condition.kind == BoundaryKind::kInlet) {
    names.velocity = scripted_velocity(words, keyword + " inlet");
    if (words.take_if("profile")) condition.profile = profile(words, keyword + " inlet", direction(side), &names.table);
  } else if (condition.kind == BoundaryKind::kNoSlip) {
    double ignored = 0;
    if (is_number(words.peek(), &ignored) || words.peek().rfind("v_", 0) == 0)
      names.velocity = scripted_velocity(words, keyword + " noslip");
    const int n = direction(side);
    if (names.velocity.number[n] != 0 || !names.velocity.variable[n].empty())
      refuse(keyword + " noslip", std::string("a velocity normal to the wall (") + kAxis[n] + ")",
             "a wall that moves in its own plane, or an inlet");
  } else if (condition.kind == BoundaryKind::kPressure) {
    condition.pressure = words.number(keyword + " pressure", "a dynamic pressure in Pa, e.g. pressure 0", kPressures);
  } else if (condition.kind == BoundaryKind::kPeriodic && !condition.name.empty()) {
    refuse(keyword, "periodic", "slip, noslip, inlet or pressure on a patch (periodic is for a whole side)");
  }
  condition.velocity = names.velocity.number;

  auto& all = script.settings.fluid.side[side];
  auto& all_names = script.names[side];
  if (all.empty()) {
    all.emplace_back();
    all_names.emplace_back();
  }
  std::size_t place = 0;
  if (!condition.name.empty())
    for (place = 1; place < all.size() && all[place].name != condition.name; ++place) {
    }

  if (started) {
    const bool known = place < all.size() && (place > 0 || script.side_given[side]);
    if (!known || all[place].kind != condition.kind || all[place].shape.kind != condition.shape.kind ||
        all[place].shape.value != condition.shape.value || all_names[place].region != names.region ||
        all[place].profile.shape != condition.profile.shape ||
        (condition.kind != BoundaryKind::kInlet && condition.kind != BoundaryKind::kNoSlip))
      refuse(keyword, "a change after the first run",
             "only new velocities there, the same condition and shape repeated: the rest is fixed at the first run");
    all_names[place].velocity = names.velocity;
    return;
  }
  if (place == all.size()) {
    all.push_back(condition);
    all_names.push_back(names);
  } else {
    if (place > 0) refuse(keyword, "a second patch of this name", "a name of its own for each patch of a side");
    if (script.side_given[side]) refuse(keyword, "a second condition for the whole side", "one");
    all[0] = condition;
    all_names[0] = names;
    script.side_given[side] = true;
  }
}

}  // namespace twogrid
