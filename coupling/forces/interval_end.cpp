#include "coupling/forces/interval_end.h"

#include <algorithm>
#include <cmath>

#include "coupling/particles/decay.h"

namespace twogrid {

namespace {

/// Rows of state are asked for so many particles ahead: they don't fit into the nearest caches.
constexpr int kAhead = 8;

template <bool kPeriodic>
inline void end_interval_of_all(const Particles& p, const std::vector<int>& who, const IntervalEnd& end,
                                ImplicitDrag* drag, FourNumbers* flux_velocity, Survey& survey) {
  const bool held = p.some_held();
  const double per_interval = 1 / end.interval;
  Four period{0, 0, 0, 0}, half{HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  for (int d = 0; d < 3; ++d)
    if (p.period[d] > 0) period[d] = p.period[d], half[d] = 0.5 * p.period[d];
  const Four none{0, 0, 0, 0};
  FourSums sums;  // impulses, volume
  Four sizes = none, largest = none, fastest = none, unbounded = none;
  double radius = survey.radius, minus_radius = survey.minus_radius, mass = survey.mass;
  const std::size_t n = who.size();
  for (std::size_t q = 0; q < n; ++q) {
    const int i = who[q];
    if (q + kAhead < n) {
      for (int column : {kFluidVelocity, kPosition}) __builtin_prefetch(p.state[who[q + kAhead]] + column, 1);
      __builtin_prefetch(p.step[who[q + kAhead]], 1);
    }
    double *const s = p.state[i], *const step = p.step[i];
    Four x, v;
    three_at(p.x[i], i + 1 == p.n, x);
    three_at(p.v[i], i + 1 == p.n, v);
    if (end.repeated > 0)
      for (int d = 0; d < 3; ++d) step[kImpulse + d] += end.repeated * (s[kDragForce + d] + s[kPressureForce + d]);
    const Four impulse = four_at(step + kImpulse).row, u = four_at(s + kFluidVelocity).row;
    const double m = p.mass[i], b = s[kResponse];
    const double per_mass = held && p.held(i) ? 0.0 : 1 / m;  // held in part: what is free in it answers
    const double response = b * mean_decay(b * end.interval * per_mass);
    Four seen = u;
    if (end.change) seen -= Four{end.change[q][0], end.change[q][1], end.change[q][2], 0};

    const double volume = sphere_volume(p.radius[i]);
    Four way = x - four_at(s + kPosition).row;
    if (kPeriodic) {
      way -= way >= half ? period : none;
      way += way <= -half ? period : none;
    }
    Four mean = way * per_interval, flux;
    if (s[kKnown] == 0) {
      mean = flux = v;
      ++survey.new_particles;
      survey.new_volume += volume;
    } else {
      flux = mean + end.extrapolation * (mean - four_at(s + kPathVelocity).row);
    }
    mean[3] = b;  // of the next column
    static_assert(kPathVelocity == kPosition + 3 && kResponse == kPathVelocity + 3);
    four_at(s + kPosition).row = x;
    four_at(s + kPathVelocity).row = mean;
    s[kKnown] = 1;
    Four given = response * seen - impulse * per_interval;
    given[3] = response;
    seen[3] = per_mass;
    drag[q].given = given;
    drag[q].seen = seen;
    four_at(flux_velocity[q].at).row = flux;

    keep_largest_size(largest, given);
    keep_largest_size(fastest, flux);
    Four to_sum = impulse, size;
    to_sum[3] = volume;
    sums.add(to_sum);
    size_of(impulse, size);
    sizes += size;
    unbounded += (x + v + impulse) * 0.0;
    radius = std::max(radius, p.radius[i]);
    minus_radius = std::max(minus_radius, -p.radius[i]);
    mass = std::max(mass, m);
  }
  survey.radius = radius, survey.minus_radius = minus_radius, survey.mass = mass;
  survey.reaction = std::max({survey.reaction, largest[0], largest[1], largest[2]});
  survey.response = std::max(survey.response, largest[3]);
  survey.flux_velocity = std::sqrt(fastest[0] * fastest[0] + fastest[1] * fastest[1] + fastest[2] * fastest[2]);
  for (int d = 0; d < 3; ++d) {
    sums.add_to(survey.impulse[d], d);
    survey.impulse_size += sizes[d];
  }
  sums.add_to(survey.volume, 3);
  survey.finite = survey.finite && unbounded[0] + unbounded[1] + unbounded[2] == 0;
}

}  // namespace

TWOGRID_VECTORISED static void end_interval_of_rows(const Particles& p, const std::vector<int>& who,
                                                    const IntervalEnd& end, ImplicitDrag* drag,
                                                    FourNumbers* flux_velocity, Survey& survey) {
  if (p.period[0] > 0 || p.period[1] > 0 || p.period[2] > 0)
    end_interval_of_all<true>(p, who, end, drag, flux_velocity, survey);
  else
    end_interval_of_all<false>(p, who, end, drag, flux_velocity, survey);
}

void end_of_interval(const Particles& p, const std::vector<int>& who, const IntervalEnd& end,
                     std::vector<ImplicitDrag>& drag, std::vector<FourNumbers>& flux_velocity, Survey& survey) {
  drag.resize(who.size());
  flux_velocity.resize(who.size());
  end_interval_of_rows(p, who, end, drag.data(), flux_velocity.data(), survey);
}

void begin(const Particles& p, const std::vector<int>& who, std::vector<ImplicitDrag>& drag,
           std::vector<FourNumbers>& flux_velocity, Survey& survey) {
  for (int i : who) {
    std::fill(p.state[i], p.state[i] + kParticleColumns, 0.0);
    std::fill(p.step[i], p.step[i] + kStepColumns, 0.0);
    for (int d = 0; d < 3; ++d) p.state[i][kPosition + d] = p.x[i][d];
  }
  end_of_interval(p, who, {1, 0, 0, nullptr}, drag, flux_velocity, survey);
  survey.new_particles = 0;
  survey.new_volume = {};
}

}  // namespace twogrid
