#include "liggghts_fixes/script/keywords.h"

namespace twogrid {
namespace {

/// Three numbers, each of which may be `auto`; or one `auto` for all.
void three_counts(const Line& line, Int3& counts, std::array<bool, 3>& automatic, const std::string& wanted) {
  double ignored = 0;
  for (int d = 0; d < 3; ++d) {
    automatic[d] = line.words.take_if("auto");
    counts[d] = automatic[d] ? 0 : line.words.whole(line.keyword, wanted, 1);
    if (d > 0 || !automatic[d] || line.words.next_is("auto") || is_number(line.words.peek(), &ignored)) continue;
    automatic = {true, true, true}, counts = {0, 0, 0};
    return;
  }
}

std::string counts_text(const Int3& counts, const std::array<bool, 3>& automatic) {
  if (automatic == std::array<bool, 3>{true, true, true}) return "auto";
  std::string text;
  for (int d = 0; d < 3; ++d) text += (d ? " " : "") + (automatic[d] ? "auto" : exact(counts[d]));
  return text;
}

void parse_stretch(const Line& line) {
  Settings& s = line.settings();
  const std::string wanted = "a growth from cell to cell between 0.5 and 2, e.g. stretch x 1.05";
  const int d = line.words.one_of(line.keyword, {"x", "y", "z"});
  s.stretch_symmetric[d] = line.words.take_if("symmetric");
  s.stretch[d] = line.number(wanted, {0.5, 2});
}

std::string stretch_text(const Script& script) {
  const Settings& s = script.settings;
  std::string text;
  for (int d = 0; d < 3; ++d)
    if (s.stretch[d] != 1)
      text += (text.empty() ? "" : "; ") + std::string(1, "xyz"[d]) + (s.stretch_symmetric[d] ? " symmetric " : " ") +
              exact(s.stretch[d]);
  return text;
}

std::string domain_text(const Script& script) {
  const auto& x = script.settings.domain;
  if (x == std::array<double, 6>{}) return "";
  std::string text = exact(x[0]);
  for (int i = 1; i < 6; ++i) text += " " + exact(x[i]);
  return text;
}

}  // namespace

const std::vector<Keyword>& fix_keywords() {
  static const std::vector<Keyword> kRows{
      {"fine", "nx ny nz, each a number or `auto`, or `auto` for all", "",
       "fine cells; `auto`: from the scene, see Grids from the scene", kRequired, "",
       [](const Line& l) {
         three_counts(l, l.settings().fine, l.script.fine_auto,
                      "three numbers of fine cells, nx ny nz, each at least 1 or auto, or auto for all three");
       },
       [](const Script& s) { return counts_text(s.settings.fine, s.fine_auto); }},
      {"density", "rho_f", "kg/m3", "", kRequired, "",
       [](const Line& l) { l.fluid().density = l.number("a fluid density above 0 (kg/m3)", kDensities); },
       [](const Script& s) { return exact(s.settings.fluid.density); }},
      {"viscosity", "mu", "Pa s", "", kRequired, "",
       [](const Line& l) { l.fluid().viscosity = l.number("a dynamic viscosity above 0 (Pa s)", kViscosities); },
       [](const Script& s) { return exact(s.settings.fluid.viscosity); }},
      {"every", "N or `auto`", "DEM steps",
       "to a coupling; `auto`: by cfl, half a response time of the particles and their way through a particle cell, 1 "
       "to 100",
       kRequired, "",
       [](const Line& l) {
         l.script.every_auto = l.words.take_if("auto");
         if (!l.script.every_auto)
           l.settings().every = l.words.whole(l.keyword, "a whole number of DEM steps, at least 1, or auto", 1);
       },
       [](const Script& s) { return s.every_auto ? "auto" : exact(s.settings.every); }},
      {"ratio", "rx ry rz, each a number or `auto`, or `auto` for all", "",
       "fine cells to a particle cell; must divide `fine`; 1 1 1 is one grid", "1 1 1; where `fine` is `auto`: `auto`",
       "",
       [](const Line& l) {
         three_counts(
             l, l.settings().ratio, l.script.ratio_auto,
             "three numbers of fine cells per particle cell, rx ry rz, each at least 1 or auto, or auto for all three");
       },
       [](const Script& s) { return counts_text(s.settings.ratio, s.ratio_auto); }},
      {"domain", "xlo xhi ylo yhi zlo zhi", "m", "where there is fluid, inside the box", "the box", "",
       [](const Line& l) {
         for (double& x : l.settings().domain) x = l.number("six bounds in m, xlo xhi ylo yhi zlo zhi", kCoordinates);
         l.script.domain_given = true;
       },
       domain_text},
      {"stretch", "`x`, `y` or `z`, then G or `symmetric` G", "",
       "each cell is G times as wide as the one before (0.5 to 2); symmetric: finest at both ends", "equal cells", "",
       parse_stretch, stretch_text, nullptr, true},
  };
  return kRows;
}

}  // namespace twogrid
