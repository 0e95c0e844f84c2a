#include "liggghts_fixes/report/scene_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cfd/boundary/patches.h"
#include "liggghts_fixes/report/bed_end.h"
#include "liggghts_fixes/report/body_lines.h"
#include "liggghts_fixes/script/boundary_words.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/output_words.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

std::string three(const Int3& v, const char* between = " x ") {
  return std::to_string(v[0]) + between + std::to_string(v[1]) + between + std::to_string(v[2]);
}
std::string three(const Vec3& v, const char* between = " ") {
  return text(v[0]) + between + text(v[1]) + between + text(v[2]);
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

}  // namespace

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
  if (s.formulation == Formulation::kB && !facts.sizes_differ())
    text.push_back("forces of grad p on particles: formulation B with one size, their share is in the drag over eps");
  if (facts.d_min == facts.d_max && facts.d_max > 0) text.push_back("mean diameters: all particles are of one size");
  if (s.fluid.convection == Convection::kNone) text.push_back("convection: none");
  return text;
}

std::string accuracy_text(const Accuracy& a, const Script& script) {
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
    else if (coupling > fluid && script.every_auto && a.every() > 1)
      text += "'every auto' lowers every step by step, in the course of a longer run";
    else if (coupling > fluid)
      text += script.every_auto ? "lower timestep, for every is 1 already"
                                : "lower every (or say 'every auto'), or timestep where every is 1 already";
    else if (!script.settings.cfl_given && script.settings.fluid.dt == 0 && a.cfl() > Accuracy::kSmallestCfl)
      text += "accuracy lowers cfl step by step, in the course of a longer run";
    else
      text +=
          std::string(script.settings.fluid.dt > 0 ? "lower dt" : "lower cfl") + " (or leave it to accuracy), or every";
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
                        : facts.sizes_differ() && !s.one_way
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
  for (const std::string& text : script.choices) {
    const auto colon = text.find(": ");
    line(text.substr(0, colon), text.substr(colon + 2));
  }
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
  const SettledBed bed = settled_bed(s, grid, facts);
  if (const double missing = short_at_end(bed, s.deposit))
    line("bed's end", "a settled bed of " + brief(bed.height) + " m: drag short by " + percent_short(missing) +
                          " of its pressure drop");
  line("gravity", three(facts.gravity) + " m/s2" +
                      (facts.weights_differ ? " on average: not all particles have the same" : "") +
                      (facts.gravity_varies ? ", and what follows a variable" : ""));
  const bool from_Umf = n.U > 0 && n.U == n.Umf;
  if (n.U > 0)
    line("velocity U", brief(n.U) + " m/s" + (from_Umf ? ", of minimum fluidisation" : "") +
                           (n.U_varies  ? from_Umf ? " (an inlet's variable is 0 now)" : " now (variable)"
                            : n.U_ahead ? ", the largest that variables give in this run"
                                        : ""));
  else if (n.U_varies)
    line("velocity U", "unknown: an inlet's variable is 0 now");
  if (n.Umf > 0)
    line("U_mf", brief(n.Umf) + " m/s (Ergun, eps 0.4)" +
                     (n.U_bed > 0 ? "; all inlets over the bed's mean section: U_s " + brief(n.U_bed) +
                                        " m/s, U_s/U_mf " + brief(n.U_bed / n.Umf)
                      : from_Umf ? ""
                                 : ", U/U_mf " + brief(n.U / n.Umf)));
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
  if (const std::string output = output_text(s.output); !output.empty()) line("output", output);
  for (const std::string& w : scene_warnings(s, grid, facts, n, every_auto)) out << "  WARNING: " << w << "\n";
  return out.str();
}

}  // namespace twogrid