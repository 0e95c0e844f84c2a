#include "liggghts_fixes/report/scene_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cfd/boundary/patches.h"
#include "cfd/grid/pi.h"
#include "coupling/forces/drag.h"
#include "liggghts_fixes/report/body_lines.h"
#include "liggghts_fixes/script/boundary_words.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

constexpr double kPatchError = 0.02;  // of a patch's area, above which it is told

std::string three(const Int3& v, const char* between = " x ") {
  return std::to_string(v[0]) + between + std::to_string(v[1]) + between + std::to_string(v[2]);
}
std::string three(const Vec3& v, const char* between = " ") {
  return text(v[0]) + between + text(v[1]) + between + text(v[2]);
}

bool sizes_differ(const SceneFacts& facts) {
  return facts.d_max > facts.d_min * (1 + 1e-9);
}

double smallest_width(const Axis& axis, int block) {
  double w = 1e300;
  for (int i = 0; i + block <= axis.n(); i += block) w = std::min(w, axis.node(i + block) - axis.node(i));
  return w;
}

/// a < b, and by more than rounding: what a script gives as exactly the limit is no case for a warning.
bool below(double a, double b) {
  return a < b * (1 - 1e-9);
}

std::string condition_text(const BoundaryCondition& c) {
  std::string word = condition_word(c.kind);
  switch (c.kind) {
    case BoundaryKind::kSlip:
    case BoundaryKind::kPeriodic:
      break;
    case BoundaryKind::kNoSlip:
      return word + (c.velocity == Vec3{0, 0, 0} ? "" : ", moving with " + three(c.velocity) + " m/s");
    case BoundaryKind::kInlet:
      return word + ", superficial " +
             (c.velocity_now ? three(c.velocity_now()) + " m/s now (variable)" : three(c.velocity) + " m/s");
    case BoundaryKind::kPressure:
      return word + " " + text(c.pressure) + " Pa";
  }
  return word;
}

double largest_inlet(const FluidSettings& fluid, bool* varies) {
  double U = 0;
  for (int s = 0; s < 6; ++s)
    for (const BoundaryCondition& c : fluid.side[s])
      if (c.kind == BoundaryKind::kInlet) {
        const Vec3 u = c.velocity_now ? c.velocity_now() : c.velocity;
        if (varies && c.velocity_now) *varies = true;
        U = std::max(U, std::abs(u[direction(s)]));
      }
  return U;
}

}  // namespace

double minimum_fluidisation(double d, double rho_p, double rho_f, double mu, double g, double eps) {
  const double e3 = eps * eps * eps;
  const double a = 1.75 * rho_f / (e3 * d), b = 150 * mu * (1 - eps) / (e3 * d * d), c = (rho_p - rho_f) * g;
  if (c <= 0 || d <= 0) return 0;
  return 2 * c / (b + std::sqrt(b * b + 4 * a * c));
}

SceneNumbers scene_numbers(const Settings& s, const FineGrid& grid, const SceneFacts& facts) {
  SceneNumbers n;
  n.h_min = n.h_coarse = 1e300;
  for (int d = 0; d < 3; ++d) {
    if (s.fine[d] == 1) continue;
    n.h_min = std::min(n.h_min, smallest_width(grid.axis[d], 1));
    n.h_coarse = std::min(n.h_coarse, smallest_width(grid.axis[d], s.ratio[d]));
  }
  if (n.h_min == 1e300) n.h_min = n.h_coarse = smallest_width(grid.axis[0], 1);

  const double rho = s.fluid.density, mu = s.fluid.viscosity, d = facts.d_mean;
  const double g = std::sqrt(facts.gravity[0] * facts.gravity[0] + facts.gravity[1] * facts.gravity[1] +
                             facts.gravity[2] * facts.gravity[2]);
  constexpr double kEps = 0.4;
  if (d > 0 && facts.density > 0) n.Umf = minimum_fluidisation(d, facts.density, rho, mu, g, kEps);
  n.U = std::max(largest_inlet(s.fluid, &n.U_varies), std::abs(s.fluid.initial_vortex));
  for (int i = 0; i < 3; ++i) {
    n.U = std::max(n.U, std::abs(s.fluid.initial_velocity[i]));
    if (s.fluid.flow_rate_set[i]) n.U = std::max(n.U, std::abs(s.fluid.flow_rate[i]));
  }
  if (n.U == 0) n.U = n.Umf;
  if (d > 0) {
    n.Re = rho * n.U * d / mu;
    if (facts.density > 0) {
      n.Stokes = facts.density * n.U * d / (9 * mu);
      const double bed_U = n.Umf > 0 ? n.Umf : n.U;
      const double beta =
          150 * (1 - kEps) * (1 - kEps) * mu / (kEps * d * d) + 1.75 * (1 - kEps) * rho * (bed_U / kEps) / d;
      n.beta = beta;
      n.tau = facts.density * (1 - kEps) / beta;
    }
  }
  if (facts.d_max > 0 && s.every > 0 && facts.dem_dt > 0) {
    double area = 1e300;  // of the smallest side between two particle cells
    for (int i = 0; i < 3; ++i)
      if (s.fine[i] > s.ratio[i])
        area = std::min(area, smallest_width(grid.axis[(i + 1) % 3], s.ratio[(i + 1) % 3]) *
                                  smallest_width(grid.axis[(i + 2) % 3], s.ratio[(i + 2) % 3]));
    n.noise = kPi / 6 * d * d * d / (s.every * facts.dem_dt * area);
  }
  n.cfl = std::max(n.U, n.Umf / kEps) * s.every * facts.dem_dt / n.h_min;
  return n;
}

int automatic_every(const SceneNumbers& n, const Settings& s, double dem_dt) {
  double interval = 100 * dem_dt;
  const double u = std::max(n.U, n.Umf / 0.4);
  if (u > 0) interval = std::min(interval, s.fluid.cfl * n.h_min / u);
  if (n.tau > 0) interval = std::min(interval, 0.5 * n.tau);
  return std::clamp(int(interval / dem_dt), 1, 100);
}

/// Of a wall inside the fluid's domain that the fluid doesn't know; else empty.
static std::string blown_through(const WallFacts& wall, const Settings& s, double h) {
  const auto& dom = s.domain;
  const double slack = 0.01 * h;
  if (wall.solid) return "";
  const bool mesh = wall.kind == WallFacts::Kind::kMesh;
  const std::string line = "'fix_modify " + s.id + " solid " + wall.id + (mesh ? " mesh " : " wall ") + wall.id + "'";
  if (wall.kind == WallFacts::Kind::kPlane) {
    const int i = wall.axis;
    const double lo = dom[2 * i], hi = dom[2 * i + 1];
    if (wall.position <= lo + slack || wall.position >= hi - slack) return "";
    const bool high = wall.position > 0.5 * (lo + hi);
    return "the wall of fix " + wall.id + " at " + "xyz"[i] + " = " + text(wall.position) +
           " stands inside the fluid's domain, and the fluid blows through it: let the domain " +
           (high ? "end" : "begin") + " there (domain ... " + kSideNames[2 * i + high] + " " + text(wall.position) +
           " ...), or say " + line;
  }
  double farthest = 0;  // corner of the domain from a cylinder's axis
  for (int i = 0; i < 3; ++i) {
    if (wall.bounds[2 * i] >= dom[2 * i + 1] - slack || wall.bounds[2 * i + 1] <= dom[2 * i] + slack) return "";
    if (i == wall.axis) continue;
    const double centre = 0.5 * (wall.bounds[2 * i] + wall.bounds[2 * i + 1]);
    const double away = std::max(std::abs(dom[2 * i] - centre), std::abs(dom[2 * i + 1] - centre));
    farthest += away * away;
  }
  if (wall.kind == WallFacts::Kind::kCylinder && farthest <= wall.radius * wall.radius) return "";
  return "the wall of fix " + wall.wall + (mesh ? " (mesh " + wall.id + ")" : " (cylinder)") +
         " stands inside the fluid's domain, and the fluid blows through it: say " + line +
         " before the first run, and it is solid for the fluid as well";
}

/// What the drag of a bed that ends somewhere in a particle cell falls short by, of its pressure drop: c D/H, D the
/// particle cell along gravity, H the height of the particles settled to eps = 0.4. c: means over places of the end, in
/// the study bed_end (cases/studies). 0: no bed to speak of.
static double short_at_bed_end(const Settings& s, const FineGrid& grid, const SceneFacts& facts, double* height) {
  int along = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(facts.gravity[d]) > std::abs(facts.gravity[along])) along = d;
  if (facts.gravity[along] == 0 || facts.particles == 0 || s.fine[along] == 1 || grid.axis[along].periodic()) return 0;
  double section = 1;
  for (int d = 0; d < 3; ++d)
    if (d != along) section *= grid.axis[d].length();
  if (facts.cut) section = facts.cut->open_volume / grid.axis[along].length();
  *height = double(facts.particles) * kPi / 6 * facts.d_mean * facts.d_mean * facts.d_mean / (0.6 * section);
  const double D = grid.axis[along].length() / s.fine[along] * s.ratio[along];
  return (s.deposit == Deposit::kTrilinear ? 0.40 : 0.27) * D / *height;
}

std::vector<std::string> scene_warnings(const Settings& s, const FineGrid& grid, const SceneFacts& facts,
                                        const SceneNumbers& n, bool every_auto) {
  std::vector<std::string> w;
  const double d = facts.d_max;
  const DragLaw* const law = find_drag_law(s.drag);
  if (sizes_differ(facts) && law && !law->for_mixtures)
    w.push_back("diameters from " + brief(facts.d_min) + " to " + brief(facts.d_max) + " m, and the drag law " +
                s.drag +
                " knows one size: it takes each particle for one among its like; for mixtures there is 'drag " +
                mixture_law_names() + "'");
  double height = 0;
  const double missing = short_at_bed_end(s, grid, facts, &height);
  if (missing > 0.05)
    w.push_back("a bed of " + brief(height) + " m holds few particle cells: where it ends, drag falls short by about " +
                brief(100 * missing) + " % of its pressure drop; lower ratio along gravity" +
                (s.deposit == Deposit::kTrilinear ? ", or 'method sharp'" : ""));
  if (d > 0 && below(n.h_coarse, 2 * d) && (s.deposit == Deposit::kCentroid || s.deposit == Deposit::kTrilinear))
    w.push_back("the smallest particle cell is " + brief(n.h_coarse / d) +
                " particle diameters, below 2, so that the void fraction is rough: raise ratio, or 'deposit exact'");
  for (int i = 0; i < 3; ++i)
    if (d > 0 && s.fine[i] == 1 && below(grid.axis[i].length(), 2 * d) && s.deposit == Deposit::kCentroid)
      w.push_back(std::string("the domain is ") + brief(grid.axis[i].length() / d) + " particle diameters deep in " +
                  "xyz"[i] + ": a void fraction over so thin a cell is an assumption");
  if (facts.contact_time > 0 && below(facts.contact_time, 10 * facts.dem_dt))
    w.push_back("a contact lasts " + brief(facts.contact_time / facts.dem_dt) +
                " DEM steps, fewer than 10: lower timestep below " + brief(facts.contact_time / 20) +
                " s, or soften the contact");
  const double interval = s.every * facts.dem_dt;
  if (n.tau > 0 && below(0.5 * n.tau, interval) && s.hold_flux == Choice::kOff)
    w.push_back("the coupling interval is " + brief(interval / n.tau) +
                " response times of the bed with 'hold off': lower every below " +
                std::to_string(std::max(1, int(0.5 * n.tau / facts.dem_dt))) + ", or 'hold auto'");
  if (below(5, n.cfl))
    w.push_back("the fluid crosses " + brief(n.cfl) + " fine cells in one coupling interval: lower every towards " +
                std::to_string(std::max(1, int(s.every / n.cfl))) +
                (s.every / n.cfl < 1 ? ", and timestep to " + brief(facts.dem_dt * s.every / n.cfl) + " s" : ""));
  if (n.U_varies && s.every > 0)
    w.push_back("an inlet follows a variable: velocity U and all that follows from it (Re, St, CFL" +
                std::string(every_auto ? ", every auto" : "") +
                ") hold for its value now; look at f_ID[3] for the run's Courant number");
  if (s.deposit == Deposit::kCentroid && !s.one_way && !facts.still && n.U > 0 && below(n.U, n.noise))
    w.push_back(
        "with 'deposit centroid' a particle that changes its particle cell replaces fluid within one coupling "
        "interval, at " +
        brief(n.noise) + " m/s over the cell's side (V_p/(interval area)) where the flow has " + brief(n.U) +
        " m/s, and the pressure is noisy, in a liquid more than useful: choose 'deposit trilinear' or 'exact', "
        "or raise every or ratio");
  for (int side = 0; side < 6; ++side) {
    const std::vector<PatchSize> sizes = patch_sizes(s.fluid, side, grid);
    for (std::size_t c = 1; c < sizes.size(); ++c) {
      const double more = sizes[c].drawn > 0 ? sizes[c].faces / sizes[c].drawn - 1 : 0.0;
      if (std::abs(more) > kPatchError)
        w.push_back(
            "patch " + s.fluid.side[side][c].name + " of " + kSideNames[side] + " takes whole fine faces, " +
            brief(sizes[c].faces) + " m2 where " + brief(sizes[c].drawn) + " m2 are drawn (" + (more > 0 ? "+" : "") +
            brief(100 * more) +
            " %), and an inlet's flow is as wrong: move its edges onto sides of fine cells, choose 'fine' so that "
            "they lie there, or take more cells across it");
    }
  }
  for (const WallFacts& wall : facts.walls)
    if (const std::string sentence = blown_through(wall, s, n.h_min); !sentence.empty()) w.push_back(sentence);
  if (facts.cut && facts.cut->narrowest > 0 && below(facts.cut->narrowest, 4))
    w.push_back("the narrowest opening between walls is " + brief(facts.cut->narrowest) +
                " cells wide, below 4: its flow is wrong by some per cent to tens of them; take finer cells by 'fine'");
  for (std::size_t b = 0; facts.cut && b < facts.cut->bodies.size(); ++b)
    if (const CutReport::OfBody& body = facts.cut->bodies[b]; body.cells == 0 && body.area == 0 && body.volume == 0)
      w.push_back("body 'solid " + body.name + "' meets no cell of the fluid's domain: see its place and its size");
  if (facts.nodes && facts.nodes->split > 0)
    w.push_back(
        "a wall parts " + std::to_string(facts.nodes->split) +
        " particle cells in two, and the void fraction smears across it: lower ratio, or move the wall onto sides "
        "of particle cells");
  if (facts.equal_kn > 0)
    w.push_back("model hooke raises a number to a power at every contact: hooke/stiffness with kn " +
                brief(facts.equal_kn) +
                " N/m has the same contact time between these particles, and runs some three times as fast");
  if (s.one_way) w.push_back("one-way: the particles feel the fluid, the fluid does not feel them");
  return w;
}

std::vector<std::string> scene_savings(const Settings& s, const SceneFacts& facts) {
  std::vector<std::string> text;
  for (int d = 0; d < 3; ++d)
    if (s.fine[d] == 1) text.push_back(std::string("velocity and gradients in ") + "xyz"[d] + ", one fine cell deep");
  if (s.one_way) {
    text.push_back("void fraction, reactions and kicks of the particles: one-way");
  } else {
    if (facts.still)
      text.push_back(
          "no particle moves: contacts and drag only at couplings and outputs, void fraction once, no kicks");
    if (s.hold_flux == Choice::kOff) text.push_back("the flux between couplings: hold off");
  }
  if (s.formulation == Formulation::kB && !sizes_differ(facts))
    text.push_back("forces of grad p on particles: formulation B with one size, their share is in the drag over eps");
  if (facts.d_min == facts.d_max && facts.d_max > 0) text.push_back("mean diameters: all particles are of one size");
  if (s.fluid.convection == Convection::kNone) text.push_back("convection: none");
  return text;
}

std::string accuracy_text(const Accuracy& a) {
  const auto percent = [](double x) { return brief(100 * x) + " %"; };
  const auto range = [](const StepControl& c) {
    return std::lround(c.shortest()) == std::lround(c.longest())
               ? std::to_string(std::lround(c.step()))
               : std::to_string(std::lround(c.shortest())) + " to " + std::to_string(std::lround(c.longest())) + ", " +
                     std::to_string(std::lround(c.step())) + " at last";
  };
  const double fluid = a.fluid().mean_error(), coupling = a.coupling().mean_error();
  std::string text = "twogrid: accuracy of the steps in time: wanted " + percent(a.wanted()) + "; " +
                     std::to_string(a.checks()) + " checks found, on average, fluid " + percent(fluid) + ", coupling " +
                     percent(coupling) + "; every " + range(a.coupling()) + "; cfl " + brief(a.cfl()) + " at last";
  if (a.checks() > 0 && std::max(fluid, coupling) > 2 * a.wanted()) {
    text += "\nWARNING: the steps in time are less accurate than wanted: ";
    if (a.coupling().noisy() || a.fluid().noisy())
      text +=
          "shorter ones don't help, since what is left is the noise of particles that cross cells; choose 'deposit "
          "trilinear' or 'exact' and 'read trilinear', or larger particle cells by ratio";
    else if (coupling > fluid)
      text += "lower every (or say 'every auto'), or timestep where every is 1 already";
    else
      text += "lower cfl (or leave it to accuracy), or every";
  }
  return text;
}

std::string scene_report(const Script& script, const FineGrid& grid, const SceneFacts& facts) {
  const Settings& s = script.settings;
  const bool every_auto = script.every_auto;
  const SceneNumbers n = scene_numbers(s, grid, facts);
  std::ostringstream out;
  const auto line = [&](const std::string& name, const std::string& value) {
    out << "  " << name << std::string(name.size() < 22 ? 22 - name.size() : 1, ' ') << value << "\n";
  };
  out << "twogrid: the scene of fix " << s.id << "\n";

  int components = 3;
  for (int f : s.fine) components -= f == 1;
  std::string models_on, absent;
  std::vector<std::string> effects{"turbulence",           "heat", "species", "lift", "virtual mass", "Basset force",
                                   "rotation by the fluid"};
  for (const Model& m : models()) {
    const std::string on = m.report(script);
    if (on.empty()) continue;
    models_on += ", " + on;
    effects.erase(std::remove(effects.begin(), effects.end(), m.effect), effects.end());
  }
  for (const std::string& e : effects) absent += (absent.empty() ? "" : ", ") + e;
  line("modelled", "volume-averaged flow, " + std::to_string(components) + " velocity components, formulation " +
                       (s.formulation == Formulation::kA ? "A" : "B") + ", drag " + s.drag +
                       (s.formulation == Formulation::kA ? ", pressure gradient force"
                        : sizes_differ(facts) && !s.one_way
                            ? ", and V_p times the pressure gradient that the drag makes, as sizes differ"
                            : "") +
                       models_on + (s.one_way ? ", one-way" : ""));
  line("not modelled", absent);
  for (const std::string& saving : scene_savings(s, facts)) line("not computed", saving);
  line("domain", "x " + text(s.domain[0]) + " to " + text(s.domain[1]) + ", y " + text(s.domain[2]) + " to " +
                     text(s.domain[3]) + ", z " + text(s.domain[4]) + " to " + text(s.domain[5]) + " m");
  Int3 coarse = s.fine;
  for (int d = 0; d < 3; ++d) coarse[d] /= s.ratio[d];
  line("fine grid", three(s.fine) + " cells, smallest " + brief(n.h_min) + " m" +
                        (facts.d_mean > 0 ? " = " + brief(n.h_min / facts.d_mean) + " d" : ""));
  line("particle grid", three(coarse) + " cells of " + three(s.ratio) + " fine ones, smallest " + brief(n.h_coarse) +
                            " m" + (facts.d_mean > 0 ? " = " + brief(n.h_coarse / facts.d_mean) + " d" : ""));
  for (const char* name : {"method", "numerics"}) line(name, report_line(name, script));
  if (const std::string flow = report_line("flow", script, true); !flow.empty()) line("flow", flow);
  for (int side = 0; side < 6; ++side)
    for (std::size_t i = 0; i < s.fluid.side[side].size(); ++i) {
      const BoundaryCondition& c = s.fluid.side[side][i];
      const bool silent = c.name.empty() && !script.side_given[side];
      std::string what = condition_text(c);
      if (silent) what += c.kind == BoundaryKind::kPeriodic ? " (as the box)" : " (not given in the script)";
      const PatchSize size = patch_sizes(s.fluid, side, grid)[i];
      if (!c.name.empty())
        what += ", " + brief(size.open) + " m2 of fine faces" +
                (size.drawn >= 0 ? " (drawn: " + brief(size.drawn) + " m2)" : "");
      if (facts.cut && i < facts.open_area[side].size() && c.kind != BoundaryKind::kPeriodic)
        what += facts.open_area[side][i] < size.open * (1 - 1e-9)
                    ? ", of " + brief(size.open) + " m2 open: " + brief(facts.open_area[side][i]) + " m2"
                    : ", wholly open";
      line(std::string(kSideNames[side]) + (c.name.empty() ? "" : " patch " + c.name), what);
    }
  for (const std::string& text : body_lines(script, facts, n)) {
    const auto colon = text.find(": ");
    line(text.substr(0, colon), text.substr(colon + 2));
  }
  line("fluid", "density " + text(s.fluid.density) + " kg/m3, viscosity " + text(s.fluid.viscosity) + " Pa s");
  if (facts.particles > 0 || facts.d_mean > 0) {
    std::string d = facts.d_min == facts.d_max
                        ? brief(facts.d_mean)
                        : brief(facts.d_min) + " to " + brief(facts.d_max) + ", mean " + brief(facts.d_mean);
    line("particles", std::to_string(facts.particles) + " now, diameter " + d + " m" +
                          (facts.density > 0 ? ", density " + brief(facts.density) + " kg/m3" : ""));
  } else {
    line("particles", "none yet");
  }
  if (facts.others > 0)
    line("outside the group",
         std::to_string(facts.others) + " particles that the fluid doesn't see: no volume, no drag");
  double bed_height = 0;
  if (const double missing = short_at_bed_end(s, grid, facts, &bed_height))
    line("bed's end", "a settled bed of " + brief(bed_height) + " m: drag short by about " + brief(100 * missing) +
                          " % of its pressure drop");
  line("gravity", three(facts.gravity) + " m/s2" +
                      (facts.weights_differ ? " on average: not all particles have the same" : "") +
                      (facts.gravity_varies ? ", and what follows a variable" : ""));
  const bool from_Umf = n.U > 0 && n.U == n.Umf;
  if (n.U > 0)
    line("velocity U", brief(n.U) + " m/s" + (from_Umf ? ", of minimum fluidisation" : "") +
                           (n.U_varies ? from_Umf ? " (an inlet's variable is 0 now)" : " now (variable)" : ""));
  else if (n.U_varies)
    line("velocity U", "unknown: an inlet's variable is 0 now");
  if (n.Umf > 0) line("U_mf", brief(n.Umf) + " m/s (Ergun, eps 0.4), U/U_mf " + brief(n.U / n.Umf));
  if (n.Re > 0) line("Re = rho U d/mu", brief(n.Re));
  if (n.Stokes > 0) line("St = rho_p U d/9mu", brief(n.Stokes));
  line("DEM step", brief(facts.dem_dt) + " s" +
                       (facts.contact_time > 0 ? ", a contact lasts " + brief(facts.contact_time / facts.dem_dt) +
                                                     " steps (" + facts.contact_time_from + ")"
                                               : ", contact time unknown"));
  if (!facts.contacts.empty()) line("contacts", facts.contacts);
  const double interval = s.every * facts.dem_dt;
  line("coupling interval",
       std::to_string(s.every) + " steps = " + brief(interval) + " s" +
           (n.tau > 0 ? ", " + brief(interval / n.tau) + " response times of the bed (tau " + brief(n.tau) + " s)"
                      : ""));
  if (s.accuracy > 0)
    line("accuracy", brief(100 * s.accuracy) + " % of the steps in time: solver tolerance " +
                         brief(s.fluid.pressure_rtol) + (s.tolerance_given ? " (as given)" : "") + ", cfl " +
                         brief(s.fluid.cfl) + (s.cfl_given || s.fluid.dt > 0 ? " (as given)" : " to begin with") +
                         ", coupling interval " + (every_auto ? "to begin with as above" : "as given") +
                         "; checked every " + std::to_string(Accuracy::kChecked) +
                         " couplings against half the fluid step");
  line("CFL over an interval", brief(n.cfl) + " (about " +
                                   std::to_string(std::max(1, int(std::ceil(n.cfl / s.fluid.cfl)))) +
                                   " fluid steps with cfl " + text(s.fluid.cfl) + ")");
  const double all_cells = double(s.fine[0]) * s.fine[1] * s.fine[2];
  const double cells = all_cells - (facts.cut ? double(facts.cut->closed_cells) : 0);
  if (facts.particles > 0) {
    // 0.1 us a particle and DEM step, 0.4 us a cell and fluid step: one core, order of magnitude only
    const double dem = 0.1e-6 * double(facts.particles) * s.every;
    const double fluid = 0.4e-6 * cells * std::max(1.0, std::ceil(n.cfl / s.fluid.cfl));
    line("expected cost", "DEM about " + std::to_string(int(100 * dem / (dem + fluid))) + " %, fluid about " +
                              std::to_string(100 - int(100 * dem / (dem + fluid))) + " %");
  }
  const double skins = facts.d_mean > 0 ? facts.skin / facts.d_mean : 0.0;
  if (facts.script_skin >= 0)
    line("neighbour skin",
         brief(facts.skin) + " m, " + brief(skins) + " diameters (the script's is " + brief(facts.script_skin) + " m)");
  else if (skins > 0 && (skins < kLeastSkin || skins > kMostSkin))
    line("neighbour skin", brief(facts.skin) + " m, " + brief(skins) +
                               " diameters; 0.25 to 0.7 diameters is fastest (-skin best takes it so)");
  line("ranks", std::to_string(facts.ranks) + " as " + three(facts.bricks) +
                    (facts.fluid_bricks == facts.bricks ? "" : ", the fluid as " + three(facts.fluid_bricks)));
  if (s.output.every > 0) line("output", s.output.file + " every " + std::to_string(s.output.every) + " steps");
  for (const std::string& w : scene_warnings(s, grid, facts, n, every_auto)) out << "  WARNING: " << w << "\n";
  return out.str();
}

}  // namespace twogrid
