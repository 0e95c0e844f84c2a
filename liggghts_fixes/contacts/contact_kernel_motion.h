// Part of the contact kernel's code (contact_kernel_code.h). Gravity, and half a step of motion.
#pragma once

#include "liggghts_fixes/contacts/contact_kernel.h"
#include "liggghts_fixes/contacts/contact_kernel_vectors.h"

namespace twogrid {
namespace {

/// Four numbers, each three times: factors of four particles' vectors.
struct Threefold {
  V low, middle, high;
  explicit Threefold(V a)
      : low(lanes<0, 0, 0, 1>(a, a)), middle(lanes<1, 1, 2, 2>(a, a)), high(lanes<2, 3, 3, 3>(a, a)) {}
};
/// a += factor b for the vectors of four particles.
inline void add(double* a, const Threefold& factor, const double* b) {
  store(a, load(a) + factor.low * load(b));
  store(a + 4, load(a + 4) + factor.middle * load(b + 4));
  store(a + 8, load(a + 8) + factor.high * load(b + 8));
}
inline bool all_in(const int* mask, int group) {
  return (mask[0] & group) && (mask[1] & group) && (mask[2] & group) && (mask[3] & group);
}

void add_weight(const Spheres& s, int group, const double g[3]) {
  const double across[12] = {g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1], g[2]};
  for (int i = 0; i < s.n_local; i += 4) {
    double* f = s.f + 3L * i;
    if (i + 4 <= s.n_local && all_in(s.mask + i, group)) {
      add(f, Threefold(load(s.mass + i)), across);
      continue;
    }
    for (int l = i; l < s.n_local && l < i + 4; ++l, f += 3)
      if (s.mask[l] & group)
        for (int k = 0; k < 3; ++k) f[k] += s.mass[l] * g[k];
  }
}

template <bool kDrift>
void move(const HalfStep& step) {
  const double spin_h = step.h / 0.4;  // of a sphere: I = 0.4 m r^2
  const double dts[4] = {step.dt, step.dt, step.dt, step.dt};
  for (int i = 0; i < step.n; i += 4) {
    double *x = step.x + 3L * i, *v = step.v + 3L * i, *omega = step.omega + 3L * i;
    const double *f = step.f + 3L * i, *torque = step.torque + 3L * i;
    if (i + 4 <= step.n && all_in(step.mask + i, step.group)) {
      const V m = load(step.mass + i), r = load(step.radius + i);
      add(v, Threefold(step.h / (m * step.mass_factor)), f);
      if (kDrift) add(x, Threefold(load(dts)), v);
      add(omega, Threefold(spin_h / (r * r * m)), torque);
      continue;
    }
    for (int l = i; l < step.n && l < i + 4; ++l, x += 3, v += 3, omega += 3, f += 3, torque += 3) {
      if (!(step.mask[l] & step.group)) continue;
      const double m = step.mass[l], r = step.radius[l];
      const double per_mass = step.h / (m * step.mass_factor), per_inertia = spin_h / (r * r * m);
      for (int k = 0; k < 3; ++k) {
        v[k] += per_mass * f[k];
        if (kDrift) x[k] += step.dt * v[k];
        omega[k] += per_inertia * torque[k];
      }
    }
  }
}

void kick(const HalfStep& step) {
  if (step.dt != 0)
    move<true>(step);
  else
    move<false>(step);
}

}  // namespace
}  // namespace twogrid
