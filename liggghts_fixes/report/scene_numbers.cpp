#include "liggghts_fixes/report/scene_numbers.h"

#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"
#include "cfd/grid/pi.h"
#include "liggghts_fixes/report/coupling_watch.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

double smallest_width(const Axis& axis, int block) {
  double w = 1e300;
  for (int i = 0; i + block <= axis.n(); i += block) w = std::min(w, axis.node(i + block) - axis.node(i));
  return w;
}

/// A velocity that may follow a variable, and what is known of it.
struct Velocity {
  double value;
  bool varies, ahead;  // holds for now only; for the run to come
};

Velocity known(double constant, bool variable, double now, const std::vector<double>& ahead, std::size_t i) {
  if (!variable) return {constant, false, false};
  if (i < ahead.size() && std::isfinite(ahead[i])) return {ahead[i], false, true};
  return {now, true, false};
}

Velocity of_inlet(const FluidSettings& fluid, int s, std::size_t i, const SceneFacts& facts) {
  const BoundaryCondition& c = fluid.side[s][i];
  const int d = direction(s);
  return known(c.velocity[d], bool(c.velocity_now), c.velocity_now ? c.velocity_now()[d] : 0, facts.ahead.side[s], i);
}

Velocity of_blow(const FluidSettings& fluid, std::size_t b, const SceneFacts& facts) {
  const Blow& blow = fluid.bodies[b].blow;
  return known(blow.velocity, bool(blow.velocity_now), blow.velocity_now ? blow.velocity_now() : 0, facts.ahead.body,
               b);
}

/// Of inlets and of bodies that blow.
Velocity largest_inlet(const FluidSettings& fluid, const SceneFacts& facts) {
  Velocity U{0, false, false};
  const auto count = [&](const Velocity& u) {
    U.value = std::max(U.value, std::abs(u.value)), U.varies |= u.varies, U.ahead |= u.ahead;
  };
  for (int s = 0; s < 6; ++s)
    for (std::size_t i = 0; i < fluid.side[s].size(); ++i)
      if (fluid.side[s][i].kind == BoundaryKind::kInlet) count(of_inlet(fluid, s, i, facts));
  for (std::size_t b = 0; b < fluid.bodies.size(); ++b)
    if (fluid.bodies[b].blow.on) count(of_blow(fluid, b, facts));
  return U;
}

/// Velocity at which a sphere sinks: its buoyant weight against the drag of Schiller & Naumann (1933), 0.44 from Re = 1000 on.
double terminal_velocity(double d, double rho_p, double rho_f, double mu, double g) {
  const double weight = std::abs(rho_p - rho_f) * g * kPi / 6 * d * d * d;
  double low = 0, high = 1;
  const auto drag = [&](double v) {
    const double Re = rho_f * v * d / mu, stokes = 3 * kPi * mu * d * v;
    return Re < 1000 ? stokes * (1 + 0.15 * std::pow(Re, 0.687)) : stokes * 0.44 * Re / 24;
  };
  while (drag(high) < weight && high < 1e6) high *= 2;
  for (int i = 0; i < 60; ++i) (drag(0.5 * (low + high)) < weight ? low : high) = 0.5 * (low + high);
  return high;
}

/// What enters by all inlets, and through bodies that blow (m3/s).
double inlets_rate(const FluidSettings& fluid, const FineGrid& grid, const SceneFacts& facts) {
  double rate = 0;
  for (int s = 0; s < 6; ++s) {
    const std::vector<PatchSize> sizes = patch_sizes(fluid, s, grid);
    for (std::size_t i = 0; i < fluid.side[s].size(); ++i) {
      const BoundaryCondition& c = fluid.side[s][i];
      if (c.kind != BoundaryKind::kInlet) continue;
      const double u = of_inlet(fluid, s, i, facts).value;
      const double area = facts.cut && i < facts.open_area[s].size() ? facts.open_area[s][i] : sizes[i].open;
      rate += std::max(0.0, is_high(s) ? -u : u) * area;
    }
  }
  for (std::size_t b = 0; facts.cut && b < fluid.bodies.size() && b < facts.cut->bodies.size(); ++b)
    if (fluid.bodies[b].blow.on) rate += of_blow(fluid, b, facts).value * facts.cut->bodies[b].blown;
  return rate;
}

}  // namespace

SettledBed settled_bed(const Settings& s, const FineGrid& grid, const SceneFacts& facts) {
  SettledBed bed;
  int along = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(facts.gravity[d]) > std::abs(facts.gravity[along])) along = d;
  if (facts.gravity[along] == 0 || facts.particles == 0 || s.fine[along] == 1 || grid.axis[along].periodic())
    return bed;
  const Axis& axis = grid.axis[along];
  double section = 1;
  for (int d = 0; d < 3; ++d)
    if (d != along) section *= grid.axis[d].length();
  double left = double(facts.particles) * kPi / 6 * facts.d_mean * facts.d_mean * facts.d_mean / 0.6;
  const double bulk = left;
  // Layer by layer from the floor up; without bodies all have the same section.
  for (int q = 0; q < axis.n() && left > 0; ++q) {
    const int i = facts.gravity[along] < 0 ? q : axis.n() - 1 - q;
    const double room = facts.cut ? facts.cut->open_layers[along][i] : section * axis.width(i);
    const bool last = left <= room || q == axis.n() - 1;
    if (last && room > 0) bed.height += std::min(1.0, left / room) * axis.width(i);
    if (!last && room > 0) bed.height += axis.width(i);
    left -= room;
  }
  if (!(bed.height > 0)) return bed;
  bed.along = along;
  bed.section = (bulk - std::max(0.0, left)) / bed.height;
  bed.cells = bed.height / (axis.length() / s.fine[along] * s.ratio[along]);
  bed.grains = bed.height / (facts.d_rough > 0 ? facts.d_rough : facts.d_mean);
  return bed;
}

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
  const Velocity inlets = largest_inlet(s.fluid, facts);
  n.U = std::max(inlets.value, std::abs(s.fluid.initial_vortex)), n.U_varies = inlets.varies, n.U_ahead = inlets.ahead;
  for (int i = 0; i < 3; ++i) {
    n.U = std::max(n.U, std::abs(s.fluid.initial_velocity[i]));
    if (s.fluid.flow_rate_set[i]) n.U = std::max(n.U, std::abs(s.fluid.flow_rate[i]));
  }
  if (const SettledBed bed = settled_bed(s, grid, facts); bed.section > 0)
    n.U_bed = inlets_rate(s.fluid, grid, facts) / bed.section;
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
  if (facts.d_max > 0 && facts.density > 0 && g > 0) {
    n.v = terminal_velocity(facts.d_max, facts.density, rho, mu, g);
    int along = 0;
    for (int i = 1; i < 3; ++i)
      if (std::abs(facts.gravity[i]) > std::abs(facts.gravity[along])) along = i;
    if (!grid.axis[along].periodic()) n.v = std::min(n.v, std::sqrt(2 * g * grid.axis[along].length()));
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

AutomaticEvery automatic_every(const SceneNumbers& n, const Settings& s, double dem_dt) {
  constexpr double kEps = 0.4;
  constexpr int kMost = 100;
  double interval = kMost * dem_dt;
  AutomaticEvery every{kMost, std::to_string(kMost) + " at most"};
  const auto within = [&](double time, const std::string& why) {
    if (time < interval) interval = time, every.why = why;
  };
  const double packed = std::max(n.U_bed, n.Umf) / kEps, u = std::max(n.U, packed);
  if (u > 0)
    within(s.fluid.cfl * n.h_min / u, "the fluid crosses " + brief(s.fluid.cfl) + " (cfl) of the smallest fine cell, " +
                                          brief(n.h_min) + " m, at " + brief(u) + " m/s" +
                                          (u > n.U      ? ", the velocity between the grains of a bed"
                                           : n.U_varies ? " (an inlet's variable, as it is now)"
                                           : n.U_ahead  ? " (the largest that inlets reach in this run)"
                                                        : ""));
  if (n.v > 0)
    within(CouplingWatch::kTravel * n.h_coarse / n.v,
           "a grain that falls, at " + brief(n.v) + " m/s, crosses " + brief(CouplingWatch::kTravel) +
               " of the smallest particle cell, " + brief(n.h_coarse) + " m");
  // Without held fluxes a bed that falls freely swings up from CouplingWatch::kUnheld on.
  const double share = s.hold_flux == Choice::kOff ? CouplingWatch::kUnheld : 0.5;
  if (n.tau > 0) within(share * n.tau, brief(share) + " response times of the bed, " + brief(n.tau) + " s each");
  every.steps = std::clamp(int(interval / dem_dt * (1 + 1e-9)), 1, kMost);
  if (interval < dem_dt) every.why += " in less than a step: lower timestep";
  return every;
}

}  // namespace twogrid
