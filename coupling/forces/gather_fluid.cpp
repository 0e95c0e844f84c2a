#include "coupling/forces/gather_fluid.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

namespace {

constexpr double kThreePi = 9.42477796076937971539;
constexpr int kAhead = 8;

/// Particles on their way through the drag law; arrays padded to whole groups.
struct Batch {
  static constexpr int kSize = 8 * kDragBatch;
  int n = 0;
  double *row[kSize], *step[kSize];  // of state and step
  alignas(64) double eps[kSize], slip[kSize], speed[kSize], diameter[kSize], per_mass[kSize], size_ratio[kSize];
  alignas(64) double Re[kSize], F[kSize], b[kSize], response[kSize], decay[kSize];
  Four drag{0, 0, 0, 0}, coefficient{0, 0, 0, 0}, number{0, 0, 0, 0}, follow{0, 0, 0, 0}, fastest{0, 0, 0, 0};
};

inline double largest_of(const Four& a) {
  return std::max(std::max(a[0], a[1]), std::max(a[2], a[3]));
}

/// slip and speed come as squares.
inline void finish(Batch& c, const GatherInputs& t) {
  int padded = c.n;
  for (; padded % kDragBatch; ++padded) {
    c.eps[padded] = c.diameter[padded] = c.size_ratio[padded] = 1;
    c.slip[padded] = c.speed[padded] = c.per_mass[padded] = 0;
  }
  const double per_viscosity = t.density / t.viscosity, scale = kThreePi * t.viscosity, dt = t.forces.decay_dt();
  const bool over_eps = t.drag_over_eps;
#pragma GCC ivdep
  for (int l = 0; l < padded; ++l) {
    c.slip[l] = std::sqrt(c.slip[l]);
    c.speed[l] = std::sqrt(c.speed[l]);
    c.Re[l] = c.eps[l] * per_viscosity * c.slip[l] * c.diameter[l];
  }
  t.law.F_of(padded, c.eps, c.Re, c.size_ratio, c.F);
#pragma GCC ivdep
  for (int l = 0; l < padded; ++l) {
    const double b_A = scale * c.diameter[l] * c.eps[l] * c.F[l], b_B = b_A / c.eps[l], b = over_eps ? b_B : b_A;
    const double k = b * dt * c.per_mass[l], decay = mean_decay_series(k);
    c.b[l] = b;
    c.response[l] = b_B;
    c.decay[l] = k > 0 && k <= kStiff ? decay : 0.0;
  }
  for (; c.n < padded; ++c.n) c.b[c.n] = c.response[c.n] = 0;
  for (int l = 0; l < padded; l += 4) {
    const Four slip = four_at(c.slip + l).row, speed = four_at(c.speed + l).row, b = four_at(c.b + l).row;
    const Four rate = four_at(c.response + l).row * four_at(c.per_mass + l).row;
    keep_largest(c.drag, b * slip);
    keep_largest(c.coefficient, b);
    keep_largest(c.number, rate * t.interval);
    keep_largest(c.follow, rate * t.read_length / (slip + speed + 1e-300));
    keep_largest(c.fastest, speed);
  }
}

inline void flush(Batch& c, const GatherInputs& t) {
  const int n = c.n;
  finish(c, t);
  for (int l = 0; l < n; ++l) {
    double *const s = c.row[l], *const step = c.step[l];
    if (step[kDecay] == 0)
      for (int d = 0; d < 3; ++d) s[kLateForce + d] = 0;
    four_at(step + kDragCoefficient).row = Four{c.b[l], 0, 0, 0};  // and the impulse
    step[kDecay] = c.decay[l];
    s[kResponse] = c.response[l];
    s[kSizeRatio] = c.size_ratio[l];
  }
  c.n = 0;
}

/// kMean: group of the mean velocity that the kick needs; 0: no kick.
template <int kMean, bool kResidual>
inline void gather_particles(Particles& p, const std::vector<int>& who, const std::vector<ImplicitDrag>& drag,
                             const GatherInputs& t, GatherMaxima& taken) {
  constexpr bool kKick = kMean > 0;
  constexpr int kGroups = (kMean == 2 ? 3 : 2) + kResidual;
  static_assert(kImpulse == kDragCoefficient + 1 && kFluidVelocity == kVoidFraction + 1 &&
                kVoidFraction == kPressureForce + 3 && kDragCoefficient == kStepVelocity + 3);
  Batch batch;
  FourSums kicks;
  Four sizes{0, 0, 0, 0};
  const std::size_t n = who.size();
  const WindowShape shape = t.reader.shape();
  const FourNumbers* const field = t.reader.field();
  const double* const size_ratio = t.size_ratio;
  const double interval = t.interval;
  const bool in_part = p.some_held_in_part();
  t.reader.at_places(p, who, t.places, [&](std::size_t q, const auto& place) {
    const int i = who[q];
    if (q + kAhead < n) {
      for (int column : {kVoidFraction, kResponse}) __builtin_prefetch(p.state[who[q + kAhead]] + column, 1);
      __builtin_prefetch(p.step[who[q + kAhead]], 1);
    }
    double *const s = p.state[i], *const step = p.step[i];
    Four out[kGroups];
    gather<kGroups>(place, shape, field, out);
    see_like_home<kGroups>(place, shape, field, out[0]);
    Four v;
    three_at(p.v[i], i + 1 == p.n, v);
    const double per_mass = drag[q].seen[3];
    if (kKick) {
      const Four kick = drag[q].given[3] * interval * (out[kMean] - drag[q].seen);
      Four change = kick * per_mass;
      if (in_part)
        for (int d = 0; d < 3; ++d)
          if (p.held(i, d)) change[d] = 0;
      v += change;
      for (int d = 0; d < 3; ++d) p.v[i][d] = v[d];
      kicks.add(kick);
      Four size;
      size_of(kick, size);
      sizes += size;
    }
    const Four slip = out[0] - v, slip2 = slip * slip, speed2 = v * v;
    const double diameter = 2 * p.radius[i], eps = out[0][3];
    if (kResidual) four_at(s + kPressureForce).row = sphere_volume(p.radius[i]) * out[kGroups - 1];
#if defined(__clang__)
    four_at(s + kVoidFraction).row = __builtin_shufflevector(out[0], out[1], 3, 4, 5, 6);
#else
    four_at(s + kVoidFraction).row = __builtin_shuffle(out[0], out[1], FourIntegers{3, 4, 5, 6});
#endif
    four_at(step + kStepVelocity).row = out[0];  // b of the next column follows
    const int l = batch.n++;
    batch.row[l] = s, batch.step[l] = step;
    batch.eps[l] = eps;
    batch.slip[l] = slip2[0] + slip2[1] + slip2[2];
    batch.speed[l] = speed2[0] + speed2[1] + speed2[2];
    batch.diameter[l] = diameter;
    batch.per_mass[l] = per_mass;
    batch.size_ratio[l] = size_ratio ? size_ratio[q] : 1.0;
    if (batch.n == Batch::kSize) flush(batch, t);
  });
  flush(batch, t);
  taken.drag = largest_of(batch.drag);
  taken.drag_coefficient = largest_of(batch.coefficient);
  taken.drag_number = largest_of(batch.number);
  taken.follow = largest_of(batch.follow);
  taken.speed = largest_of(batch.fastest);
  for (int d = 0; d < 3; ++d) {
    kicks.add_to(taken.kick[d], d);
    taken.kick_size += sizes[d];
  }
}

}  // namespace

TWOGRID_VECTORISED void correct_and_gather(Particles& p, const std::vector<int>& who,
                                           const std::vector<ImplicitDrag>& drag, const GatherInputs& t,
                                           GatherMaxima& taken) {
  const int mean = !t.kick ? 0 : t.mean_loaded ? 2 : 1;
  if (t.residual)
    mean == 2   ? gather_particles<2, true>(p, who, drag, t, taken)
    : mean == 1 ? gather_particles<1, true>(p, who, drag, t, taken)
                : gather_particles<0, true>(p, who, drag, t, taken);
  else
    mean == 2   ? gather_particles<2, false>(p, who, drag, t, taken)
    : mean == 1 ? gather_particles<1, false>(p, who, drag, t, taken)
                : gather_particles<0, false>(p, who, drag, t, taken);
}

}  // namespace twogrid
