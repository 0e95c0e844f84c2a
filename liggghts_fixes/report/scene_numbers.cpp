#include "liggghts_fixes/report/scene_numbers.h"

#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"
#include "cfd/grid/pi.h"

namespace twogrid {

namespace {

double smallest_width(const Axis& axis, int block) {
  double w = 1e300;
  for (int i = 0; i + block <= axis.n(); i += block) w = std::min(w, axis.node(i + block) - axis.node(i));
  return w;
}

double now(const Blow& blow) {
  return blow.velocity_now ? blow.velocity_now() : blow.velocity;
}

/// Of inlets and of bodies that blow.
double largest_inlet(const FluidSettings& fluid, bool* varies) {
  double U = 0;
  for (int s = 0; s < 6; ++s)
    for (const BoundaryCondition& c : fluid.side[s])
      if (c.kind == BoundaryKind::kInlet) {
        const Vec3 u = c.velocity_now ? c.velocity_now() : c.velocity;
        if (varies && c.velocity_now) *varies = true;
        U = std::max(U, std::abs(u[direction(s)]));
      }
  for (const Body& body : fluid.bodies)
    if (body.blow.on) {
      U = std::max(U, now(body.blow));
      if (varies && body.blow.velocity_now) *varies = true;
    }
  return U;
}

/// What enters by all inlets, and through bodies that blow (m3/s).
double inlets_rate(const FluidSettings& fluid, const FineGrid& grid, const SceneFacts& facts) {
  double rate = 0;
  for (int s = 0; s < 6; ++s) {
    const std::vector<PatchSize> sizes = patch_sizes(fluid, s, grid);
    for (std::size_t i = 0; i < fluid.side[s].size(); ++i) {
      const BoundaryCondition& c = fluid.side[s][i];
      if (c.kind != BoundaryKind::kInlet) continue;
      const double u = (c.velocity_now ? c.velocity_now() : c.velocity)[direction(s)];
      const double area = facts.cut && i < facts.open_area[s].size() ? facts.open_area[s][i] : sizes[i].open;
      rate += std::max(0.0, is_high(s) ? -u : u) * area;
    }
  }
  for (std::size_t b = 0; facts.cut && b < fluid.bodies.size() && b < facts.cut->bodies.size(); ++b)
    if (fluid.bodies[b].blow.on) rate += now(fluid.bodies[b].blow) * facts.cut->bodies[b].blown;
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
  n.U = std::max(largest_inlet(s.fluid, &n.U_varies), std::abs(s.fluid.initial_vortex));
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

}  // namespace twogrid
