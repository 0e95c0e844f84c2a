// What every DEM step of every particle costs: drag, pressure gradient force and buoyancy in the common case, in which
// no flux is held, no particle is held and the step is short against the particle's response time.
#pragma once

#include "cfd/grid/box.h"
#include "coupling/particles/particles.h"

namespace twogrid {

/// What all particles of a step have in common.
struct PlainStep {
  double dt, lift;                   ///< s; -rho_f (kg/m3)
  Vec3 g;                            ///< m/s2
  const Weight* by_group = nullptr;  ///< in place of g, where the particles' weights are not all alike
  int groups = 0;
};

/// f <- phi (f - V_p rho_f g + F_p + b (u - v)), phi = kDecay; impulse and, where watched, drag of the step are noted.
/// pressure: there is a pressure gradient force F_p. Particles whose decay isn't known are left alone: their indices go
/// to left[] (room for p.n), their number is returned. Local.
int add_plain_forces(const Particles& p, const PlainStep& step, bool pressure, int* left);

}  // namespace twogrid
