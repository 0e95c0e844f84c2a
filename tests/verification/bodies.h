// Flows around and inside bodies that the grid cuts, for verification.
#pragma once

#include <cstdint>

#include "cfd/bodies/simple_shapes.h"
#include "tests/verification/cfd_box.h"

namespace twogrid {

inline Body body(std::shared_ptr<const SolidShape> shape, const char* name = "body") {
  Body b;
  b.name = name;
  b.shape = std::move(shape);
  return b;
}

/// A number in [0,1) that hangs on n alone.
inline double random_number(int n) {
  std::uint64_t x = std::uint64_t(n + 7) * 0x9E3779B97F4A7C15ull;
  x ^= x >> 31, x *= 0xBF58476D1CE4E5B9ull, x ^= x >> 29, x *= 0x94D049BB133111EBull, x ^= x >> 32;
  return double(x >> 11) * 0x1p-53;
}

/// Of a liquid so viscous that its convection is nothing: density 1, viscosity 1; steps as long as wanted.
inline FluidSettings creeping(double dt) {
  FluidSettings s;
  s.density = 1;
  s.viscosity = 1;
  s.convection = Convection::kNone;
  s.implicit_viscosity = Choice::kOn;
  s.pressure_rtol = 1e-7;
  s.dt = dt;
  for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
  return s;
}

/// A tube along y and a ball, in a gas that moves.
inline FluidSettings tube_and_ball(Convection scheme, Choice implicit) {
  FluidSettings s;
  s.density = 1.2;
  s.viscosity = 2e-3;
  s.convection = scheme;
  s.implicit_viscosity = implicit;
  s.pressure_rtol = 1e-12;
  s.dt = 2e-3;
  for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
  s.bodies = {
      body(std::make_shared<CylinderShape>(Vec3{0.31, 0, 0.36}, Vec3{0, 1, 0}, 0.13, FluidIs::kOutside), "tube"),
      body(std::make_shared<SphereShape>(Vec3{0.72, 0.52, 0.7}, 0.17, FluidIs::kOutside), "ball")};
  return s;
}

/// Mean over the volume of the whole box of the flux along d (m/s): superficial velocity.
inline double superficial(const CfdBox& box, int d) {
  double sum[2] = {0, 0};
  for_each(box.own(), [&](int i, int j, int k) {
    Int3 next{i, j, k};
    ++next[d];
    const double V = box.grid.volume(i, j, k);
    sum[0] += V * 0.5 * (box.fluid->flux(d, i, j, k) + box.fluid->flux(d, next[0], next[1], next[2]));
    sum[1] += V;
  });
  return box.sum(sum[0]) / box.sum(sum[1]);
}

/// Of the whole box, what lies beside closed faces, too (m3): what a mean gradient drives.
inline double open_volume(const CfdBox& box) {
  double sum = 0;
  for_each(box.own(),
           [&](int i, int j, int k) { sum += box.grid.volume(i, j, k) * box.fluid->open_shares()->theta()(i, j, k); });
  return box.sum(sum);
}

/// Steps of the given length until the superficial velocity along d changes by less than `change` of itself in one.
/// Returns the number of steps, or -1 if `most` are not enough.
inline int until_steady(CfdBox& box, int d, double dt, double change, int most) {
  double before = 0;
  for (int n = 1; n <= most; ++n) {
    box.step(dt);
    const double now = superficial(box, d);
    if (std::abs(now - before) < change * std::abs(now)) return n;
    before = now;
  }
  return -1;
}

}  // namespace twogrid
