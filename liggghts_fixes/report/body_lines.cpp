#include "liggghts_fixes/report/body_lines.h"

#include <cmath>

#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

/// Thickness sqrt(mu eps/beta) of the layer in which a packed bed's flow feels a wall (m); 0: unknown.
double friction_layer(const Settings& s, const SceneNumbers& n) {
  constexpr double kEps = 0.4;
  return n.beta > 0 ? std::sqrt(s.fluid.viscosity * kEps / n.beta) : 0;
}

/// ", its surface moves ..."; nothing of a body at rest.
std::string surface_motion_text(const Settings& s, std::size_t b) {
  if (b >= s.fluid.bodies.size() || !s.fluid.bodies[b].motion.any() || s.fluid.bodies[b].slip) return "";
  const SurfaceMotion& m = s.fluid.bodies[b].motion;
  const auto three = [](const Vec3& x) { return brief(x[0]) + " " + brief(x[1]) + " " + brief(x[2]); };
  return m.turning == Vec3{0, 0, 0}
             ? ", its surface moves with " + three(m.velocity) + " m/s"
             : ", its surface turns with " + three(m.turning) + " rad/s about " + three(m.origin);
}

/// What it blows into the fluid.
std::string blow_text(const Settings& s, std::size_t b, double area, double drawn) {
  if (b >= s.fluid.bodies.size() || !s.fluid.bodies[b].blow.on) return "";
  const Blow& blow = s.fluid.bodies[b].blow;
  const double U = blow.velocity_now ? blow.velocity_now() : blow.velocity;
  return ", blows " + brief(U) + " m/s" + (blow.velocity_now ? " now (variable)" : "") + " through " + brief(area) +
         " m2 of it" + (drawn > 0 ? " (drawn " + brief(drawn) + " m2), " : ", ") + brief(U * area) + " m3/s";
}

}  // namespace

std::vector<std::string> blown_lines(const Script& script, const FluidSolver& fluid) {
  std::vector<std::string> lines;
  if (!fluid.blowing()) return lines;
  for (std::size_t b = 0; b < script.bodies.size() && b < fluid.body_forces().size(); ++b)
    if (script.bodies[b].blows) {
      const double U = fluid.blowing()->velocity()[b];
      lines.push_back("solid " + script.bodies[b].name + " blows " + brief(U) + " m/s at the end, " +
                      brief(U * fluid.blowing()->area()[b]) + " m3/s; " + brief(fluid.body_forces()[b].blown) +
                      " m3/s on average over the last coupling interval");
    }
  return lines;
}

std::vector<std::string> body_lines(const Script& script, const SceneFacts& facts, const SceneNumbers& n) {
  std::vector<std::string> lines;
  if (!facts.cut) return lines;
  const Settings& s = script.settings;
  const CutReport& cut = *facts.cut;
  bool rubs = false, slips = false;
  for (std::size_t b = 0; b < cut.bodies.size() && b < script.bodies.size(); ++b) {
    const BodyNames& names = script.bodies[b];
    const CutReport::OfBody& body = cut.bodies[b];
    (names.slip ? slips : rubs) = true;
    const char* const kinds[] = {"mesh ", "wall ", "region "};
    lines.push_back("solid " + names.name + ": " + kinds[int(names.kind)] + names.id +
                    (names.sheet ? ", a sheet" : "") + (names.slip ? ", slip; " : ", noslip; ") + brief(body.area) +
                    " m2 of its surface in the fluid" + (names.sheet ? ", both sides, " : ", ") +
                    (body.volume > 0 ? brief(body.volume) + " m3 closed, " : "") + std::to_string(body.cells) +
                    (names.sheet ? " cells beside it" : " cells cut") + surface_motion_text(s, b) +
                    blow_text(s, b, body.blown, b < facts.drawn_blowing.size() ? facts.drawn_blowing[b] : 0));
  }
  if (!cut.fluid_side.empty()) lines.push_back("fluid is: " + cut.fluid_side);
  double domain = 1;
  for (int d = 0; d < 3; ++d) domain *= s.domain[2 * d + 1] - s.domain[2 * d];
  const double cells = double(s.fine[0]) * s.fine[1] * s.fine[2];
  lines.push_back(
      "open to the fluid: " + brief(cut.open_volume) + " m3, " + brief(100 * cut.open_volume / domain) +
      " % of the domain; " + std::to_string(cut.closed_cells) + " of " + std::to_string((long long)cells) +
      " cells closed" +
      (cut.pocket_volume > 0 ? ", of them " + brief(cut.pocket_volume) + " m3 in pockets that nothing leads to" : ""));
  if (cut.sheet_faces > 0)
    lines.push_back("sheets: " + std::to_string(cut.sheet_faces) +
                    " faces closed by them, in steps; their place is right to half a cell");
  if (cut.narrowest > 0) lines.push_back("narrowest opening: " + brief(cut.narrowest) + " cells");
  if (facts.nodes)
    lines.push_back("particle cells: " + std::to_string(facts.nodes->cut - facts.nodes->closed) + " cut, of which " +
                    std::to_string(facts.nodes->merged) +
                    " share their value with a neighbour; smallest open part of a "
                    "cell and what it shares with: " +
                    brief(facts.nodes->smallest) + " of a whole one");
  lines.push_back(
      "walls in cut cells: second order in the cell" + std::string(slips ? "; slip: first order" : "") +
      (cut.slivers > 0 ? "; " + std::to_string(cut.slivers) + " faces are slivers: pressure and friction only" : "") +
      (cut.thin_edges > 0 ? "; " + std::to_string(cut.thin_edges) +
                                " edges of cells are crossed twice: what is finer than a cell there is cut off"
                          : ""));
  if (const double layer = friction_layer(s, n); rubs && layer > 0)
    lines.push_back("wall's layer in a bed: " + brief(layer) + " m = " + brief(layer / n.h_min) + " cells" +
                    (layer < 2 * n.h_min
                         ? ": friction on walls is not resolved there and falls short; flow and pressure "
                           "drop of the bed don't hang on it"
                         : ""));
  return lines;
}

}  // namespace twogrid
