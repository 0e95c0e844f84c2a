#include "liggghts_fixes/script/keywords.h"

namespace twogrid {
namespace {

template <class T>
std::string three(const T& v) {
  return exact(v[0]) + " " + exact(v[1]) + " " + exact(v[2]);
}

void three_counts(const Line& line, Int3& counts, const std::string& wanted) {
  for (int& n : counts) n = line.words.whole(line.keyword, wanted, 1);
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
      {"fine", "nx ny nz", "", "fine cells", kRequired, "",
       [](const Line& l) {
         three_counts(l, l.settings().fine, "three numbers of fine cells, nx ny nz, each at least 1");
       },
       [](const Script& s) { return three(s.settings.fine); }},
      {"density", "rho_f", "kg/m3", "", kRequired, "",
       [](const Line& l) { l.fluid().density = l.number("a fluid density above 0 (kg/m3)", kDensities); },
       [](const Script& s) { return exact(s.settings.fluid.density); }},
      {"viscosity", "mu", "Pa s", "", kRequired, "",
       [](const Line& l) { l.fluid().viscosity = l.number("a dynamic viscosity above 0 (Pa s)", kViscosities); },
       [](const Script& s) { return exact(s.settings.fluid.viscosity); }},
      {"every", "N or `auto`", "DEM steps",
       "to a coupling; `auto`: by cfl and half a response time of the particles, 1 to 100", kRequired, "",
       [](const Line& l) {
         l.script.every_auto = l.words.take_if("auto");
         if (!l.script.every_auto)
           l.settings().every = l.words.whole(l.keyword, "a whole number of DEM steps, at least 1, or auto", 1);
       },
       [](const Script& s) { return s.every_auto ? "auto" : exact(s.settings.every); }},
      {"ratio", "rx ry rz", "", "fine cells to a particle cell; must divide `fine`; 1 1 1 is one grid", "", "",
       [](const Line& l) {
         three_counts(l, l.settings().ratio,
                      "three numbers of fine cells per particle cell, rx ry rz, each at least 1");
       },
       [](const Script& s) { return three(s.settings.ratio); }},
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
