#include "coupling/forces/plain_forces.h"

#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// Rows of many particles' state don't fit into the nearest caches: they are asked for so many particles ahead.
constexpr int kAhead = 8;
static_assert(kDragCoefficient == kStepVelocity + 3 && kImpulse == kDragCoefficient + 1 && kDecay == kImpulse + 3);

template <bool kPressure, bool kWatched, bool kByGroup>
inline int add(const Particles& p, const PlainStep& step, int* left) {
  Four g{step.g[0], step.g[1], step.g[2], 0};
  int count = 0;
  for (int i = 0; i < p.n; ++i) {
    if (!p.takes_part(i)) continue;
    double* const step_state = p.step[i];
    double* const s = kPressure || kWatched ? p.state[i] : nullptr;
    if ((kPressure || kWatched) && i + kAhead < p.n) __builtin_prefetch(p.state[i + kAhead] + kPressureForce, 1);
    const double b = step_state[kDragCoefficient], decay = step_state[kDecay];
    if (decay == 0) {
      left[count++] = i;
      continue;
    }
    // Fourth numbers: b beside u, the next particle's beside f and v; what comes of them goes nowhere.
    double* const f = p.f[i];
    const bool last = i + 1 == p.n;
    Four other, v;
    three_at(f, last, other);
    three_at(p.v[i], last, v);
    if (kByGroup) {
      g = Four{0, 0, 0, 0};
      for (int w = 0; w < step.groups; ++w)
        if (!p.mask || (p.mask[i] & step.by_group[w].group))
          for (int d = 0; d < 3; ++d) g[d] += step.by_group[w].g[d];
    }
    other += step.lift * sphere_volume(p.radius[i]) * g;
    Four force = other;
    if (kPressure) force += four_at(s + kPressureForce).row;
    force = (force + b * (four_at(step_state + kStepVelocity).row - v)) * decay;
    const Four received = force - other;
    Four impulse = received * step.dt;
    impulse[3] = 0;  // of the decay
    four_at(step_state + kImpulse).row += impulse;
    if (kWatched)
      for (int d = 0; d < 3; ++d) s[kDragForce + d] = kPressure ? received[d] - s[kPressureForce + d] : received[d];
    for (int d = 0; d < 3; ++d) f[d] = force[d];
  }
  return count;
}

}  // namespace

TWOGRID_VECTORISED int add_plain_forces(const Particles& p, const PlainStep& step, bool pressure, int* left) {
  if (step.groups > 0) return pressure ? add<true, true, true>(p, step, left) : add<false, true, true>(p, step, left);
  if (p.watched) return pressure ? add<true, true, false>(p, step, left) : add<false, true, false>(p, step, left);
  return pressure ? add<true, false, false>(p, step, left) : add<false, false, false>(p, step, left);
}

}  // namespace twogrid
