#include "liggghts_fixes/script/script_parser.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "coupling/forces/drag.h"
#include "coupling/methods.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

const char* const kAxis = "xyz";

std::string side_name(int side) {
  return kSideNames[side];
}

int side_of(const std::string& name) {
  for (int s = 0; s < 6; ++s)
    if (name == kSideNames[s]) return s;
  return -1;
}

Vec3 three_numbers(Words& words, const std::string& keyword, const std::string& wanted) {
  Vec3 v;
  for (double& x : v) x = words.number(keyword, wanted);
  return v;
}

ScriptedVelocity scripted_velocity(Words& words, const std::string& keyword) {
  const std::string wanted = "three velocities in m/s, numbers or v_NAME";
  ScriptedVelocity v;
  for (int d = 0; d < 3; ++d) {
    const std::string& next = words.peek();
    if (next.rfind("v_", 0) == 0 && next.size() > 2) {
      v.variable[d] = words.word(keyword, wanted).substr(2);
    } else {
      v.number[d] = words.number(keyword, wanted);
    }
  }
  return v;
}

// ---- boundary ----------------------------------------------------------------------------------------------------

std::vector<std::array<double, 2>> read_table(const std::string& keyword, const std::string& file) {
  std::ifstream in(file);
  const std::string wanted = "a readable file of two columns, coordinate (m, ascending) and factor on the velocity";
  if (!in) refuse(keyword, file, wanted);
  std::vector<std::array<double, 2>> table;
  std::string line;
  while (std::getline(in, line)) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r,") == std::string::npos) continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    char* end = nullptr;
    std::array<double, 2> row{};
    row[0] = std::strtod(line.c_str(), &end);
    char* second = end;
    row[1] = std::strtod(second, &end);
    if (end == second || !std::isfinite(row[0]) || !std::isfinite(row[1]) ||
        (!table.empty() && row[0] <= table.back()[0]))
      refuse(keyword, "the line '" + line + "' in " + file, wanted);
    table.push_back(row);
  }
  if (table.size() < 2)
    refuse(keyword, std::to_string(table.size()) + " lines in " + file, wanted + ", at least two lines");
  return table;
}

InletProfile profile(Words& words, const std::string& keyword, int normal) {
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
    p.table = read_table(keyword + " profile table", words.word(keyword + " profile table", "a file name"));
  }
  return p;
}

PatchShape patch_shape(Words& words, const std::string& keyword, std::string* region) {
  PatchShape shape;
  const int kind = words.one_of(keyword, {"rect", "circle", "region"});
  if (kind == 0) {
    shape.kind = PatchShape::Kind::kRectangle;
    const std::string wanted = "four bounds in m, lo hi lo hi in the side's two directions, each lo below its hi";
    for (double& v : shape.value) v = words.number(keyword + " rect", wanted);
    if (!(shape.value[0] < shape.value[1]) || !(shape.value[2] < shape.value[3]))
      refuse(
          keyword + " rect",
          text(shape.value[0]) + " " + text(shape.value[1]) + " " + text(shape.value[2]) + " " + text(shape.value[3]),
          wanted);
  } else if (kind == 1) {
    shape.kind = PatchShape::Kind::kCircle;
    shape.value[0] = words.number(keyword + " circle", "the centre's two coordinates (m) and a radius (m)");
    shape.value[1] = words.number(keyword + " circle", "the centre's two coordinates (m) and a radius (m)");
    shape.value[2] = words.positive(keyword + " circle", "a radius above 0 (m)");
  } else {
    shape.kind = PatchShape::Kind::kRegion;
    *region = words.word(keyword + " region", "the id of a LIGGGHTS region");
  }
  return shape;
}

/// boundary SIDE [patch NAME shape] condition
void parse_boundary(Script& script, Words& words, bool started) {
  const std::string side_word = words.word("boundary", "a side: xlo, xhi, ylo, yhi, zlo or zhi");
  const int side = side_of(side_word);
  if (side < 0) refuse("boundary", side_word, "a side: xlo, xhi, ylo, yhi, zlo or zhi");
  std::string keyword = "boundary " + side_word;

  BoundaryCondition condition;
  ConditionNames names;
  if (words.take_if("patch")) {
    condition.name = words.word(keyword + " patch", "a name and a shape: rect, circle or region");
    keyword += " patch " + condition.name;
    condition.shape = patch_shape(words, keyword, &names.region);
  }

  const int kind = words.one_of(keyword, {"slip", "noslip", "inlet", "pressure", "periodic"});
  condition.kind = BoundaryKind(kind);
  if (condition.kind == BoundaryKind::kInlet) {
    names.velocity = scripted_velocity(words, keyword + " inlet");
    if (words.take_if("profile")) condition.profile = profile(words, keyword + " inlet", direction(side));
  } else if (condition.kind == BoundaryKind::kNoSlip) {
    double ignored = 0;
    if (is_number(words.peek(), &ignored) || words.peek().rfind("v_", 0) == 0)
      names.velocity = scripted_velocity(words, keyword + " noslip");
    const int n = direction(side);
    if (names.velocity.number[n] != 0 || !names.velocity.variable[n].empty())
      refuse(keyword + " noslip", std::string("a velocity normal to the wall (") + kAxis[n] + ")",
             "a wall that moves in its own plane, or an inlet");
  } else if (condition.kind == BoundaryKind::kPressure) {
    condition.pressure = words.number(keyword + " pressure", "a dynamic pressure in Pa, e.g. pressure 0");
  } else if (condition.kind == BoundaryKind::kPeriodic && !condition.name.empty()) {
    refuse(keyword, "periodic", "slip, noslip, inlet or pressure on a patch (periodic is for a whole side)");
  }
  condition.velocity = names.velocity.number;

  auto& conditions = script.settings.fluid.side[side];
  auto& all_names = script.names[side];
  if (conditions.empty()) {
    conditions.emplace_back();
    all_names.emplace_back();
  }
  std::size_t place = 0;
  if (!condition.name.empty())
    for (place = 1; place < conditions.size() && conditions[place].name != condition.name; ++place) {
    }

  if (started) {
    const bool known = place < conditions.size() && (place > 0 || script.side_given[side]);
    if (!known || conditions[place].kind != condition.kind || conditions[place].shape.kind != condition.shape.kind ||
        conditions[place].shape.value != condition.shape.value || all_names[place].region != names.region ||
        conditions[place].profile.shape != condition.profile.shape ||
        (condition.kind != BoundaryKind::kInlet && condition.kind != BoundaryKind::kNoSlip))
      refuse(keyword, "a change after the first run",
             "only new velocities there, the same condition and shape repeated: the rest is fixed at the first run");
    all_names[place].velocity = names.velocity;
    return;
  }
  if (place == conditions.size()) {
    conditions.push_back(condition);
    all_names.push_back(names);
  } else {
    if (place > 0) refuse(keyword, "a second patch of this name", "a name of its own for each patch of a side");
    if (script.side_given[side]) refuse(keyword, "a second condition for the whole side", "one");
    conditions[0] = condition;
    all_names[0] = names;
    script.side_given[side] = true;
  }
}

// ---- the other keywords --------------------------------------------------------------------------------------------

void parse_output(Script& script, Words& words, bool started) {
  OutputSettings& out = script.settings.output;
  if (words.take_if("off")) {
    out.every = 0;
    return;
  }
  static const std::vector<std::string> kFields{"u", "p", "eps", "faces"};
  bool any = false;
  for (;; any = true) {
    if (words.take_if("every")) {
      out.every = words.whole("output every", "a whole number of DEM steps, at least 1", 1);
    } else if (!started && words.take_if("file")) {
      out.file = words.word("output file", "a file name");
    } else if (!started && words.take_if("fields")) {
      out.fields.clear();
      while (std::find(kFields.begin(), kFields.end(), words.peek()) != kFields.end())
        out.fields.push_back(words.word("output fields", ""));
      if (out.fields.empty()) refuse("output fields", words.peek(), listed(kFields));
    } else if (!started && words.take_if("particles")) {
      out.particles = words.yes_or_no("output particles");
    } else if (!started && words.take_if("average")) {
      words.one_of("output average", {"from"});
      out.average_from = words.number("output average from", "a time in s, at least 0");
      if (out.average_from < 0) refuse("output average from", text(out.average_from), "a time in s, at least 0");
    } else {
      break;
    }
  }
  if (!any)
    refuse("output", words.peek(),
           started ? "off or every N (the rest is fixed at the first run)"
                   : "every N file F [fields u p eps] [particles yes|no] [average from T], or off");
}

struct Keyword {
  std::string name;
  void (*parse)(Settings&, Words&);
};

Choice choice(Words& words, const std::string& keyword) {
  return Choice(words.one_of(keyword, {"off", "on", "auto"}));
}

/// Keywords of fix_modify that set one thing, by name.
const std::vector<Keyword>& keywords() {
  static const std::vector<Keyword> kKeywords{
      {"drag",
       [](Settings& s, Words& w) {
         s.drag = w.word("drag", "one of " + drag_law_names());
         if (!find_drag_law(s.drag)) refuse("drag", s.drag, "one of " + drag_law_names());
       }},
      {"formulation",
       [](Settings& s, Words& w) {
         s.formulation = Formulation(w.one_of("formulation", {"A", "B"}));
       }},
      {"method",
       [](Settings& s, Words& w) {
         const std::string name = w.word("method", "one of " + method_names());
         const Method* method = find_method(name);
         if (!method) refuse("method", name, "one of " + method_names());
         choose(*method, method->length ? w.positive("method " + name, std::string("a ") + method->length) : 0.0, s);
       }},
      {"deposit",
       [](Settings& s, Words& w) {
         s.deposit = Deposit(w.one_of("deposit", {"centroid", "trilinear", "exact", "cube"}));
         if (s.deposit == Deposit::kCube) s.cube_edge = w.positive("deposit cube", "an edge above 0 (m)");
       }},
      {"prolong",
       [](Settings& s, Words& w) {
         s.prolong = Prolong(w.one_of("prolong", {"constant", "linear"}));
       }},
      {"read",
       [](Settings& s, Words& w) {
         s.read = Read(w.one_of("read", {"cell", "trilinear", "fine", "fine/trilinear", "kernel", "cube"}));
         if (s.read == Read::kKernel) s.kernel_width = w.positive("read kernel", "a full width above 0 (m)");
         if (s.read == Read::kCube) {
           const double edge = w.positive("read cube", "an edge above 0 (m)");
           if (s.deposit == Deposit::kCube && s.cube_edge != edge)
             refuse("read cube", text(edge), "the edge of deposit cube, " + text(s.cube_edge));
           s.cube_edge = edge;
         }
       }},
      {"eps",
       [](Settings& s, Words& w) {
         w.one_of("eps", {"bound"});
         s.bound = EpsBound(w.one_of("eps bound", {"move", "clip"}));
         const std::string found = w.peek();
         s.eps_min = w.number("eps bound", "a smallest void fraction between 0 and 1");
         if (!(s.eps_min > 0 && s.eps_min < 1)) refuse("eps bound", found, "a smallest void fraction between 0 and 1");
       }},
      {"interpolate",
       [](Settings& s, Words& w) {
         s.interpolate = Interpolate(w.one_of("interpolate", {"smooth", "linear"}));
       }},
      {"hold", [](Settings& s, Words& w) { s.hold_flux = choice(w, "hold"); }},
      {"one-way", [](Settings& s, Words& w) { s.one_way = w.yes_or_no("one-way"); }},
      {"initial",
       [](Settings& s, Words& w) {
         if (w.one_of("initial", {"u", "vortex"}) == 0)
           s.fluid.initial_velocity = three_numbers(w, "initial u", "three velocities in m/s");
         else
           s.fluid.initial_vortex = w.number("initial vortex", "a velocity in m/s");
       }},
      {"accuracy",
       [](Settings& s, Words& w) {
         const std::string found = w.peek(), wanted = "a relative error of the steps in time, 0.0001 to 0.5";
         s.accuracy = w.number("accuracy", wanted);
         if (!(s.accuracy >= 1e-4 && s.accuracy <= 0.5)) refuse("accuracy", found, wanted);
       }},
      {"cfl",
       [](Settings& s, Words& w) {
         s.cfl_given = true;
         const std::string found = w.peek();
         s.fluid.cfl = w.positive("cfl", "a Courant number above 0 and at most 1");
         if (s.fluid.cfl > 1) refuse("cfl", found, "a Courant number above 0 and at most 1");
       }},
      {"dt", [](Settings& s, Words& w) { s.fluid.dt = w.positive("dt", "a largest fluid step above 0 (s)"); }},
      {"convection",
       [](Settings& s, Words& w) {
         s.fluid.convection = Convection(w.one_of("convection", {"none", "vanleer", "central"}));
       }},
      {"implicit", [](Settings& s, Words& w) { s.fluid.implicit_viscosity = choice(w, "implicit"); }},
      {"gap",
       [](Settings& s, Words& w) {
         w.one_of("gap", {"friction"});
         s.fluid.gap_friction = w.one_of("gap friction", {"off", "on"}) == 1;
       }},
      {"pressure_gradient",
       [](Settings& s, Words& w) {
         s.fluid.pressure_gradient = three_numbers(w, "pressure_gradient", "three gradients in Pa/m");
       }},
      {"flow_rate",
       [](Settings& s, Words& w) {
         const int d = w.one_of("flow_rate", {"x", "y", "z"});
         s.fluid.flow_rate[d] = w.number("flow_rate", "a mean superficial velocity in m/s");
         s.fluid.flow_rate_set[d] = true;
       }},
      {"tolerance",
       [](Settings& s, Words& w) {
         s.tolerance_given = true;
         const std::string found = w.peek();
         s.fluid.pressure_rtol = w.positive("tolerance", "a relative continuity error above 0 and below 0.1");
         if (s.fluid.pressure_rtol >= 0.1)
           refuse("tolerance", found, "a relative continuity error above 0 and below 0.1");
       }},
  };
  return kKeywords;
}

std::string fix_modify_keywords() {
  std::vector<std::string> names;
  for (const Keyword& k : keywords()) names.push_back(k.name);
  names.insert(names.end(), {"boundary", "output"});
  return listed(names);
}

// ---- checks of several keywords together ---------------------------------------------------------------------------

/// The edge of a cube or the width of a kernel, that stands on cells of `block` fine ones.
void check_length(const std::string& keyword, const std::string& what, double length, const Settings& s,
                  const FineGrid& grid, const Int3& block) {
  constexpr double kLeast = 1e-3;  // of a cell: below, the whole of it lies in one cell, and 1/length overflows at last
  double narrowest = std::numeric_limits<double>::max(), longest = 0;
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    longest = std::max(longest, a.length());
    for (int i = 0; i + block[d] <= a.n(); i += block[d])
      narrowest = std::min(narrowest, a.node(i + block[d]) - a.node(i));
    if (length > a.length() && s.fine[d] > 1)
      refuse(keyword, text(length),
             "a" + std::string(what == "edge" ? "n " : " ") + what + " that fits into the domain, " + text(a.length()) +
                 " in " + kAxis[d]);
  }
  if (!(length >= kLeast * narrowest && length <= longest))
    refuse(keyword, text(length),
           "a" + std::string(what == "edge" ? "n " : " ") + what + " of some particle diameters (m), at least " +
               text(kLeast) + " of the smallest cell, " + text(narrowest) + " m");
}

}  // namespace

Script parse_fix(const std::string& id, const std::vector<std::string>& all) {
  Script script;
  Settings& s = script.settings;
  s.id = id;
  Words words(all);
  std::set<std::string> seen;
  while (!words.end()) {
    const std::string keyword = words.word("", "");
    if (keyword != "stretch" && !seen.insert(keyword).second) refuse(keyword, "it twice", "it once");
    if (keyword == "fine") {
      for (int& n : s.fine) n = words.whole("fine", "three numbers of fine cells, nx ny nz, each at least 1", 1);
    } else if (keyword == "ratio") {
      for (int& r : s.ratio)
        r = words.whole("ratio", "three numbers of fine cells per particle cell, rx ry rz, each at least 1", 1);
    } else if (keyword == "domain") {
      for (double& x : s.domain) x = words.number("domain", "six bounds in m, xlo xhi ylo yhi zlo zhi");
      script.domain_given = true;
    } else if (keyword == "stretch") {
      const int d = words.one_of("stretch", {"x", "y", "z"});
      s.stretch_symmetric[d] = words.take_if("symmetric");
      const std::string found = words.peek();
      s.stretch[d] = words.positive("stretch", "a growth from cell to cell between 0.5 and 2, e.g. stretch x 1.05");
      if (s.stretch[d] < 0.5 || s.stretch[d] > 2)
        refuse("stretch", found, "a growth from cell to cell between 0.5 and 2, e.g. stretch x 1.05");
    } else if (keyword == "density") {
      s.fluid.density = words.positive("density", "a fluid density above 0 (kg/m3)");
    } else if (keyword == "viscosity") {
      s.fluid.viscosity = words.positive("viscosity", "a dynamic viscosity above 0 (Pa s)");
    } else if (keyword == "every") {
      script.every_auto = words.take_if("auto");
      if (!script.every_auto) s.every = words.whole("every", "a whole number of DEM steps, at least 1, or auto", 1);
    } else {
      throw std::invalid_argument("unknown keyword '" + keyword +
                                  "' in fix twogrid, wanted fine, ratio, domain, stretch, density, viscosity or every");
    }
  }
  for (const char* needed : {"fine", "density", "viscosity", "every"})
    if (!seen.count(needed)) {
      static const std::map<std::string, std::string> kWanted{{"fine", "fine nx ny nz"},
                                                              {"density", "density and a value in kg/m3"},
                                                              {"viscosity", "viscosity and a value in Pa s"},
                                                              {"every", "every and a number of DEM steps, or auto"}};
      refuse(needed, "no such keyword in the fix command", kWanted.at(needed));
    }
  for (int d = 0; d < 3; ++d)
    if (s.fine[d] % s.ratio[d] != 0)
      refuse("ratio", text(s.ratio[d]) + " in " + kAxis[d] + " for fine " + text(s.fine[d]),
             "a ratio that divides the number of fine cells: " + text(s.fine[d]) + " is no multiple of " +
                 text(s.ratio[d]));
  return script;
}

void parse_fix_modify(Script& script, const std::vector<std::string>& all, bool started) {
  if (all.empty()) refuse("fix_modify", "no keyword", fix_modify_keywords());
  Script changed = script;  // a line that is wrong changes nothing
  Words words(all);
  while (!words.end()) {
    const std::string name = words.word("", "");
    if (name == "boundary") {
      parse_boundary(changed, words, started);
      continue;
    }
    if (name == "output") {
      parse_output(changed, words, started);
      continue;
    }
    if (name == "model") {
      const std::string model = words.word("model", "a name");
      throw std::invalid_argument("model " + model +
                                  ": there is no model of this name yet, in fact none at all; take the line out");
    }
    const auto k = std::find_if(keywords().begin(), keywords().end(), [&](const Keyword& k) { return k.name == name; });
    if (k == keywords().end())
      throw std::invalid_argument("unknown keyword '" + name + "' in fix_modify, wanted " + fix_modify_keywords());
    if (started)
      refuse(name, "a change after the first run",
             "it before: only velocities of inlets and walls and the times of output may change later");
    k->parse(changed.settings, words);
  }
  script = std::move(changed);
}

std::array<bool, 3> periodic_directions(const FluidSettings& fluid) {
  std::array<bool, 3> p{};
  for (int d = 0; d < 3; ++d) p[d] = !fluid.side[2 * d].empty() && fluid.side[2 * d][0].kind == BoundaryKind::kPeriodic;
  return p;
}

FineGrid fine_grid(const Settings& s, const std::array<bool, 3>& periodic) {
  FineGrid grid;
  for (int d = 0; d < 3; ++d)
    grid.axis[d] =
        Axis(graded_nodes(s.domain[2 * d], s.domain[2 * d + 1], s.fine[d], s.stretch[d], s.stretch_symmetric[d]),
             periodic[d]);
  return grid;
}

void check_box_boundary(const int boundary[3][2]) {
  static const char kCode[] = "pfsm";
  bool bad = false;
  std::string found, wanted;
  for (int d = 0; d < 3; ++d) {
    std::string lo(1, kCode[boundary[d][0]]), hi(1, kCode[boundary[d][1]]);
    bad |= boundary[d][0] > 1 || boundary[d][1] > 1;
    found += " " + (lo == hi ? lo : lo + hi);
    wanted += boundary[d][0] == 0 ? " p" : " f";
  }
  if (bad)
    refuse("boundary", "'boundary" + found + "', whose s or m sides move the box",
           "a box that stays, 'boundary" + wanted + "', before the box is created");
}

void complete(Script& script, const BoxFacts& box) {
  Settings& s = script.settings;
  if (!script.domain_given) s.domain = box.bounds;
  for (int d = 0; d < 3; ++d) {
    const double lo = s.domain[2 * d], hi = s.domain[2 * d + 1];
    const double box_lo = box.bounds[2 * d], box_hi = box.bounds[2 * d + 1], slack = 1e-9 * (box_hi - box_lo);
    const std::string found = text(lo) + " to " + text(hi) + " in " + kAxis[d];
    if (!(lo < hi)) refuse("domain", found, "a lower bound below the upper one");
    // of its cells, volumes and squares are formed
    if (!((hi - lo) / s.fine[d] > 1e-50 && hi - lo < 1e50 && hi - lo > 1e-9 * std::max(std::abs(lo), std::abs(hi))))
      refuse("domain", found, "lengths in m that can be divided into cells");
    if (lo < box_lo - slack || hi > box_hi + slack)
      refuse("domain", found, "bounds inside the simulation box, " + text(box_lo) + " to " + text(box_hi));
    // bounds that mean the box's are the box's, to the bit
    if (std::abs(lo - box_lo) <= slack) s.domain[2 * d] = box_lo;
    if (std::abs(hi - box_hi) <= slack) s.domain[2 * d + 1] = box_hi;
  }

  FluidSettings& f = s.fluid;
  for (int d = 0; d < 3; ++d) {
    const bool spans = s.domain[2 * d] == box.bounds[2 * d] && s.domain[2 * d + 1] == box.bounds[2 * d + 1];
    const bool periodic = box.periodic[d] && spans;
    for (int side : {2 * d, 2 * d + 1}) {
      if (f.side[side].empty()) {
        f.side[side].emplace_back();
        script.names[side].emplace_back();
      }
      BoundaryCondition& whole = f.side[side][0];
      const std::string keyword = "boundary " + side_name(side);
      if (periodic) {
        if (f.side[side].size() > 1 || (script.side_given[side] && whole.kind != BoundaryKind::kPeriodic))
          refuse(
              keyword, "a condition on a side that is periodic for the particles",
              std::string("no condition there, or f instead of p in ") + kAxis[d] + " in LIGGGHTS' boundary command");
        whole.kind = BoundaryKind::kPeriodic;
      } else if (whole.kind == BoundaryKind::kPeriodic) {
        refuse(keyword, "periodic",
               spans ? std::string("p instead of f in ") + kAxis[d] +
                           " in LIGGGHTS' boundary command, or another condition"
                     : std::string("a domain that spans the whole periodic box in ") + kAxis[d]);
      }
      for (const BoundaryCondition& c : f.side[side])
        if (s.fine[d] == 1 && (c.kind == BoundaryKind::kInlet || c.kind == BoundaryKind::kPressure))
          refuse(keyword + (c.name.empty() ? "" : " patch " + c.name),
                 std::string("flow through a side of a direction with fine 1, ") + kAxis[d],
                 "slip or periodic there, or at least 2 fine cells");
    }
    if (f.flow_rate_set[d] && f.pressure_gradient[d] != 0)
      refuse("flow_rate", std::string("it in ") + kAxis[d] + " together with pressure_gradient", "one of the two");
    if (s.stretch[d] != 1 && periodic)
      refuse("stretch", std::string("it in ") + kAxis[d] + ", which is periodic", "equal cells there");
  }
  const FineGrid grid = fine_grid(s, periodic_directions(f));
  f.check(grid);
  if (f.gap_friction && std::none_of(s.fine.begin(), s.fine.end(), [](int n) { return n == 1; }))
    refuse("gap friction", "on with fine " + text(s.fine[0]) + " " + text(s.fine[1]) + " " + text(s.fine[2]),
           "a direction with one fine cell, or off");
  const bool cube = s.deposit == Deposit::kCube || s.read == Read::kCube;
  if (cube)
    check_length(s.deposit == Deposit::kCube ? "deposit cube" : "read cube", "edge", s.cube_edge, s, grid, s.ratio);
  if (s.read == Read::kKernel) check_length("read kernel", "width", s.kernel_width, s, grid, {1, 1, 1});
  if (s.one_grid && s.ratio != Int3{1, 1, 1})
    refuse("method " + s.method,
           "ratio " + text(s.ratio[0]) + " " + text(s.ratio[1]) + " " + text(s.ratio[2]) + " in the fix command",
           "ratio 1 1 1, for this method sees the particles on the fine cells; or one of the two-grid methods");
  if (s.output.every > 0 && s.output.file.empty()) refuse("output", "no file", "file and a name");
  if (s.output.every == 0 && !s.output.file.empty()) refuse("output", "no every", "every and a number of DEM steps");
  if (s.output.every > 0 && !script.every_auto && s.output.every % s.every != 0)
    refuse("output every", std::to_string(s.output.every), "a multiple of the fix's every, " + std::to_string(s.every));
}

}  // namespace twogrid
