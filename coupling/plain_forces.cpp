#include "plain_forces.h"

#include "../cfd/vectorised.h"
#include "deposit.h"

namespace twogrid {

namespace {

/// The rows of many particles' state don't fit into the nearest caches: they are asked for so many particles ahead.
constexpr int kAhead = 8;
static_assert(kDragCoefficient == kStepVelocity + 3 && kImpulse == kDragCoefficient + 1 && kDecay == kImpulse + 3);

template <bool kPressure, bool kWatched>
inline int add(const Particles& p, const PlainStep& step, int* left) {
  const Four g{step.g[0], step.g[1], step.g[2], 0};
  int count = 0;
  for (int i = 0; i < p.n; ++i) {
    if (!p.takes_part(i)) continue;
    double* const s = p.state[i];
    if (i + kAhead < p.n) {
      __builtin_prefetch(p.state[i + kAhead] + kStepVelocity, 1);
      if (kPressure || kWatched) __builtin_prefetch(p.state[i + kAhead] + kPressureForce, 1);
    }
    const double b = s[kDragCoefficient], decay = s[kDecay];
    if (decay == 0) {
      left[count++] = i;
      continue;
    }
    double* const f = p.f[i];
    const double *const v = p.v[i], *const u = s + kStepVelocity, *const pressure = s + kPressureForce;
    const double buoyancy = step.lift * sphere_volume(p.radius[i]);
    const Four other = Four{f[0], f[1], f[2], 0} + buoyancy * g;
    const Four pressed{pressure[0], pressure[1], pressure[2], 0};
    Four force = other;
    if (kPressure) force += pressed;
    force = (force + b * (Four{u[0], u[1], u[2], 0} - Four{v[0], v[1], v[2], 0})) * decay;
    const Four received = force - other;
    const Four drag = kPressure ? received - pressed : received;
    const Four impulse = received * step.dt;
    for (int d = 0; d < 3; ++d) {
      s[kImpulse + d] += impulse[d];
      if (kWatched) s[kDragForce + d] = drag[d];
      f[d] = force[d];
    }
  }
  return count;
}

}  // namespace

TWOGRID_VECTORISED int add_plain_forces(const Particles& p, const PlainStep& step, bool pressure, int* left) {
  if (p.watched) return pressure ? add<true, true>(p, step, left) : add<false, true>(p, step, left);
  return pressure ? add<true, false>(p, step, left) : add<false, false>(p, step, left);
}

}  // namespace twogrid
