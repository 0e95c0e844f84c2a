// fix twogrid and fix_modify: from words to settings, as deep as it goes without LIGGGHTS.
#include <mpi.h>

#include <cmath>
#include <fstream>
#include <map>

#include "cfd/boundary/patches.h"
#include "coupling/output/output.h"
#include "liggghts_fixes/report/grid_scene.h"
#include "liggghts_fixes/report/memory_need.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/script_parser.h"
#include "tests/fuzz/fuzz.h"

namespace twogrid_fuzz {
namespace {

using namespace twogrid;
using Lines = std::vector<std::vector<std::string>>;

Lines lines(const std::vector<std::string>& texts) {
  Lines all;
  for (const std::string& t : texts) all.push_back(split(t));
  return all;
}

/// A line by a row of the table: its words, words in `quotes` of its values, numbers.
std::vector<std::string> by_row(const Keyword& row, Dice& dice) {
  static const std::vector<std::string> kNumbers{"0", "1", "2", "4", "0.1", "0.5", "1e-5", "0.002", "-1"};
  std::vector<std::string> line = split(row.words), quoted;
  for (std::size_t at = 0, end = 0; (at = row.values.find('`', at)) != std::string::npos; at = end + 1) {
    end = row.values.find('`', at + 1);
    if (end == std::string::npos) break;
    quoted.push_back(row.values.substr(at + 1, end - at - 1));
  }
  for (std::size_t n = dice.below(5); n > 0; --n)
    for (const std::string& w : split(!quoted.empty() && !dice.one_in(3) ? dice.of(quoted) : dice.of(kNumbers)))
      line.push_back(w);
  return line;
}

const Lines& fix_lines() {
  static const Lines kLines = lines({"fine 8 4 16 ratio 4 2 4 density 1.2 viscosity 1.8e-5 every 10",
                                     "fine 8 1 16 ratio 4 1 4 density 1000 viscosity 1e-3 every auto",
                                     "fine 10 20 30 ratio 5 4 3 domain 0 0.008 0 0.008 0 0.016 stretch x 1.1 stretch z "
                                     "symmetric 0.9 density 2 viscosity 3 every 1",
                                     "fine 8 8 16 density 1.2 viscosity 1.8e-5 every 7 domain 0 0.004 0 0.008 0 0.008",
                                     "density 1 viscosity 1 every 100 ratio 1 1 1 fine 2 2 2",
                                     "fine auto density 1.2 viscosity 1.8e-5 every auto",
                                     "fine auto 1 auto ratio 3 1 auto density 1.2 viscosity 1.8e-5 every 5",
                                     "fine 16 8 24 ratio auto density 1.2 viscosity 1.8e-5 every 5 stretch x 1.1"});
  return kLines;
}

const Lines& modify_lines() {
  static const std::string kTable = folder() + "/table.txt";
  static const Lines kLines = lines({"drag kochhill formulation A method jets",
                                     "deposit exact prolong linear read kernel 0.002",
                                     "method cube 0.003",
                                     "method single",
                                     "read fine deposit cube 0.002 read cube 0.002",
                                     "eps bound clip 0.35 interpolate linear hold off one-way yes",
                                     "initial u 1 2 3 initial vortex 0.1 cfl 0.7 dt 1e-4",
                                     "convection central implicit on gap friction on cfl 0.5",
                                     "pressure_gradient 0 0 -5",
                                     "flow_rate x 0.2 flow_rate y 0.1",
                                     "tolerance 1e-8 accuracy 0.01",
                                     "output every 20 file bed.h5 fields u eps particles no average from 0.5",
                                     "output every 40 file bed.h5",
                                     "output off",
                                     "boundary zlo inlet 0 0 0.4 boundary zhi pressure 0",
                                     "boundary zlo inlet 0 v_U 0.123 boundary zhi pressure -2 boundary xlo noslip",
                                     "boundary zlo patch jet rect 0 0.004 0 0.004 inlet 0 0 5 profile parabolic xy",
                                     "boundary zlo patch plate circle 0.004 0.004 0.002 noslip boundary zhi pressure 1",
                                     "boundary zlo patch hole region R pressure 3 boundary xlo noslip 0 v_V 0",
                                     "boundary zlo inlet 0 0 1 profile table x " + kTable + " boundary zhi pressure 0",
                                     "boundary xlo periodic boundary xhi periodic",
                                     "boundary ylo slip boundary yhi noslip 1 0 0",
                                     "checkpoint every 30 min keep 3 folder here",
                                     "checkpoint every 1000 checkpoint every 2 h",
                                     "checkpoint read a.h5",
                                     "checkpoint write a.h5",
                                     "model gap friction on"});
  return kLines;
}

std::vector<std::string> some_modify(Dice& dice) {
  std::vector<std::string> line;
  for (std::size_t n = 1 + dice.below(dice.one_in(3) ? 3 : 1); n > 0; --n) {
    const std::vector<std::string> more =
        dice.one_in(4) ? by_row(dice.of(fix_modify_keywords()), dice) : dice.of(modify_lines());
    line.insert(line.end(), more.begin(), more.end());
  }
  return line;
}

BoxFacts some_box(Dice& dice) {
  BoxFacts box;
  box.bounds = {0, 0.008, 0, 0.008, 0, 0.016};
  for (bool& p : box.periodic) p = dice.one_in(4);
  if (dice.one_in(10)) {
    static const std::vector<double> kOdd{0, -1, NAN, INFINITY, -INFINITY, 1e300, 1e-300, 1e20, 0.008, 1e6};
    box.bounds[dice.below(6)] = dice.of(kOdd);
  }
  return box;
}

/// What must hold of numbers that were accepted. Limits by themselves, not those of the parser.
std::vector<Bound> bounds(const Script& script) {
  const Settings& s = script.settings;
  const FluidSettings& f = s.fluid;
  constexpr double kMost = 2147483647, kFast = 1e6, kFar = 1e6, kStrong = 1e12;
  std::vector<Bound> b{{"density", f.density, 1e-9, 1e9},
                       {"viscosity", f.viscosity, 1e-18, 1e12},
                       {"every", double(s.every), 1, kMost},
                       {"initial vortex", f.initial_vortex, -kFast, kFast},
                       {"cfl", f.cfl, 1e-15, 1},
                       {"dt", f.dt, 0, 1e9},
                       {"tolerance", f.pressure_rtol, 1e-16, 0.1},
                       {"accuracy", s.accuracy, 0, 0.5},
                       {"eps bound", s.eps_min, 1e-3, 0.999},
                       {"read kernel", s.kernel_width, 0, kFar},
                       {"cube", s.cube_edge, 0, kFar},
                       {"output every", double(s.output.every), 0, kMost},
                       {"output average from", s.output.average_from, -1, 1e9},
                       {"checkpoint every", double(script.checkpoints.every), 0, 1e15},
                       {"checkpoint every min", script.checkpoints.seconds, 0, 1e9},
                       {"checkpoint keep", double(script.checkpoints.keep), 1, kMost}};
  for (int d = 0; d < 3; ++d) {
    const bool known = !script.fine_auto[d] && !script.ratio_auto[d];
    b.push_back({"fine", double(s.fine[d]), script.fine_auto[d] ? 0.0 : 1.0, script.fine_auto[d] ? 0.0 : kMost});
    b.push_back({"ratio", double(s.ratio[d]), script.ratio_auto[d] ? 0.0 : 1.0, known ? double(s.fine[d]) : kMost});
    b.push_back({"stretch", s.stretch[d], 0.5, 2});
    b.push_back({"initial u", f.initial_velocity[d], -kFast, kFast});
    b.push_back({"pressure_gradient", f.pressure_gradient[d], -kStrong, kStrong});
    b.push_back({"flow_rate", f.flow_rate[d], -kFast, kFast});
  }
  for (double x : s.domain) b.push_back({"domain", x, -kFar, kFar});
  for (int side = 0; side < 6; ++side) {
    b.push_back({"conditions as names", double(f.side[side].size()), double(script.names[side].size()),
                 double(script.names[side].size())});
    for (const BoundaryCondition& c : f.side[side]) {
      for (double u : c.velocity) b.push_back({"boundary's velocity", u, -kFast, kFast});
      for (double x : c.shape.value) b.push_back({"patch", x, -kFar, kFar});
      for (const auto& row : c.profile.table)
        b.push_back({"table", row[0], -kFar, kFar}), b.push_back({"table", row[1], -1e6, 1e6});
      b.push_back({"boundary pressure", c.pressure, -kStrong, kStrong});
      // The whole side's condition comes first, without a name; all others have one.
      b.push_back({"patches without a name", double(&c != &f.side[side][0] && c.name.empty()), 0, 0});
      b.push_back({"a shape of a whole side",
                   double(&c == &f.side[side][0] && c.shape.kind != PatchShape::Kind::kWhole), 0, 0});
    }
  }
  return b;
}

std::map<std::string, std::string> texts(const Script& script) {
  std::map<std::string, std::string> all;
  for (const auto& [keyword, value] : settings_texts(script)) all[keyword] = value;
  return all;
}

/// The words that these rows print.
std::vector<std::string> printed(const std::vector<Keyword>& rows, const Script& script) {
  std::string s;
  for (const Keyword& k : rows) {
    if (!k.value) continue;
    std::string value = k.value(script);
    for (std::size_t end; k.parts && (end = value.find("; ")) != std::string::npos; value = value.substr(end + 2))
      s += " " + k.words + " " + value.substr(0, end);
    if (!value.empty()) s += " " + k.words + " " + value;
  }
  return split(s);
}

bool has_blanks(const std::vector<std::string>& words) {
  for (const std::string& w : words)
    if (split(w).size() != 1 || w.find(';') != std::string::npos) return true;
  return false;
}

/// What the record of an output file says is what was given.
std::string unlike_its_record(const Script& script) {
  Script again = parse_fix("gas", printed(fix_keywords(), script));
  const std::vector<std::string> words = printed(fix_modify_keywords(), script);
  if (!words.empty()) parse_fix_modify(again, words, false);
  const auto first = texts(script), second = texts(again);
  for (const auto& [keyword, value] : first)
    if (second.at(keyword) != value)
      return "the record says " + keyword + " " + value + ", which is read as " + second.at(keyword);
  return "";
}

SceneFacts some_facts(Dice& dice) {
  SceneFacts facts;
  facts.particles = (long long)dice.below(100000), facts.dem_dt = 1e-5;
  facts.d_min = facts.d_mean = facts.d_max = dice.one_in(4) ? 0 : 1e-3, facts.density = dice.one_in(4) ? 0 : 2500;
  facts.d_rough = facts.d_max, facts.d_most = (dice.one_in(2) ? 1 : 3) * facts.d_max;
  facts.gravity[2] = dice.one_in(4) ? 0 : -9.81;
  return facts;
}

std::string report_of(const Script& script, const FineGrid& grid, Dice& dice) {
  const SceneFacts facts = some_facts(dice);
  const SceneNumbers n = scene_numbers(script.settings, grid, facts);
  const double kAny = 1e300;
  const std::string wrong =
      outside({{"h_min", n.h_min, 1e-60, 1e60},
               {"h_coarse", n.h_coarse, 1e-60, 1e60},
               {"U", n.U, 0, 1e7},
               {"Umf", n.Umf, 0, kAny},
               {"Re", n.Re, 0, kAny},
               {"Stokes", n.Stokes, 0, kAny},
               {"tau", n.tau, 0, kAny},
               {"noise", n.noise, 0, kAny},
               {"cfl", n.cfl, 0, kAny},
               {"automatic every", double(automatic_every(n, script.settings, facts.dem_dt).steps), 1, 100}});
  if (!wrong.empty()) return wrong;
  scene_warnings(script.settings, grid, facts, n, script.every_auto);
  return scene_report(script, grid, facts).empty() ? "an empty scene report" : "";
}

/// In place of auto.
void choose(Script& script, const BoxFacts& box, Dice& dice) {
  Script some = with_some_cells(script);
  complete(some, box);
  for (auto& side : some.settings.fluid.side)
    for (BoundaryCondition& c : side)
      if (c.shape.kind == PatchShape::Kind::kRegion) c.shape.inside = [](const Vec3& x) { return x[0] > 0.003; };
  const GridChoice choice = choose_grids(grid_scene(some.settings, some_facts(dice), {}), given_grids(script));
  script.settings.fine = choice.fine, script.settings.ratio = choice.ratio;
  script.fine_auto = script.ratio_auto = {false, false, false};
}

}  // namespace

Verdict try_script(Dice& dice) {
  std::vector<std::string> fix = dice.of(fix_lines()), modify = some_modify(dice), later = some_modify(dice);
  {
    std::string table = "# z factor\n0 0\n0.004 1.5\n0.008 0\n";
    if (dice.one_in(3)) mutate_text(table, dice);
    std::ofstream(folder() + "/table.txt") << table;
  }
  for (std::size_t n = dice.below(3); n > 0 && dice.one_in(2); --n) mutate(fix, dice, fix_lines());
  for (std::size_t n = dice.below(3); n > 0; --n) mutate(modify, dice, modify_lines());
  if (dice.one_in(2)) mutate(later, dice, modify_lines());
  const BoxFacts box = some_box(dice);
  std::string all =
      "fix " + joined(fix) + "\n  fix_modify " + joined(modify) + "\n  later " + joined(later) + "\n  box";
  for (double x : box.bounds) all += " " + std::to_string(x);
  note(all);

  Script script;
  std::vector<std::string> words = fix;
  Verdict v = tried([&] { script = parse_fix("gas", fix); }, words);
  const auto wrong = [&](std::string what) {
    if (v.defect.empty()) v.defect = std::move(what);
    return !v.defect.empty();
  };
  if (!v.accepted || wrong(outside(bounds(script)))) return v;
  words = modify;
  v = tried(
      [&] {
        parse_fix_modify(script, modify, false);
        if (!script.settings.output.file.empty()) check(script.settings.output);
      },
      words);
  if (!v.accepted || wrong(outside(bounds(script)))) return v;
  if (!has_blanks(fix) && !has_blanks(modify)) {
    std::string unlike;
    const Verdict record = tried([&] { unlike = unlike_its_record(script); }, words);
    if (wrong(record.accepted ? unlike
                              : "its own record is not read: " + joined(printed(fix_modify_keywords(), script))))
      return v;
  }
  words.insert(words.end(), fix.begin(), fix.end());
  if (script.grids_auto()) {
    v = tried([&] { choose(script, box, dice); }, words);
    if (!v.accepted || wrong(outside(bounds(script)))) return v;
  }
  const double cells = double(script.settings.fine[0]) * script.settings.fine[1] * script.settings.fine[2];
  const double most_cells = 2147483647;
  v = tried([&] { check_memory(MPI_COMM_SELF, script.settings, {1, 1, 1}, most_cells, script.bodies.size()); }, words);
  if (!v.accepted || cells > 1e5) return v;
  FineGrid grid;
  v = tried(
      [&] {
        complete(script, box);
        check(script.settings);
        grid = fine_grid(script.settings, periodic_directions(script.settings.fluid));
        for (auto& side : script.settings.fluid.side)
          for (BoundaryCondition& c : side)
            if (c.shape.kind == PatchShape::Kind::kRegion) c.shape.inside = [](const Vec3&) { return true; };
        script.settings.fluid.check_flow(grid);
      },
      words);
  if (!v.accepted || wrong(outside(bounds(script)))) return v;
  std::string found;
  v = tried([&] { found = report_of(script, grid, dice); }, words);
  if (!v.accepted || wrong(found)) return v;
  const Verdict changed = tried([&] { parse_fix_modify(script, later, true); }, later);
  if (wrong(changed.defect)) return v;
  if (changed.accepted) wrong(outside(bounds(script)));
  return v;
}

}  // namespace twogrid_fuzz
