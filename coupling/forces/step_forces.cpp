#include "coupling/forces/step_forces.h"

#include <algorithm>
#include <cmath>

#include "coupling/forces/plain_forces.h"

namespace twogrid {

namespace {

constexpr int kStiffRounds = 4;

/// A run goes on: the force of the next half kick is known of the last step, whose mean motion and slip set-up can't
/// see. Where it is far from what they would be now, a command has changed velocities, and it is not taken.
void take_up(const double* s, const Vec3& other, Vec3& first, Vec3& second) {
  Vec3 known;
  double difference = 0, size = 0;
  for (int d = 0; d < 3; ++d) {
    const double received = s[kDragForce + d] + s[kPressureForce + d] + 0.5 * s[kLateForce + d];
    known[d] = other[d] + received;
    difference += (known[d] - first[d]) * (known[d] - first[d]);
    size += received * received;
  }
  if (difference <= 2.5e-3 * size) first = second = known;
}

}  // namespace

void StepForces::set_gravity(const std::vector<Weight>& weights) {
  gravity_ = {0, 0, 0};
  by_group_.clear();
  const auto of_all = [](const Weight& w) { return w.group == ~0; };
  if (std::all_of(weights.begin(), weights.end(), of_all)) {
    for (const Weight& w : weights)
      for (int d = 0; d < 3; ++d) gravity_[d] += w.g[d];
  } else {
    by_group_ = weights;
  }
}

Vec3 StepForces::gravity_of(const Particles& p, int i) const {
  Vec3 g{0, 0, 0};
  for (const Weight& w : by_group_)
    if (!p.mask || (p.mask[i] & w.group))
      for (int d = 0; d < 3; ++d) g[d] += w.g[d];
  return g;
}

void StepForces::operator()(Particles& p, double dem_dt, bool accumulate, MeanMotion* holding) {
  const bool held = p.some_held();
  stiff_.clear();
  if (holding)
    on_all<true, true>(p, dem_dt, accumulate, holding);
  else if (held)
    on_all<false, true>(p, dem_dt, accumulate, nullptr);
  else if (accumulate)
    plain(p, dem_dt);
  else
    on_all<false, false>(p, dem_dt, false, nullptr);
  if (accumulate) state_.last_dt = dem_dt;
}

template <bool kHolding, bool kHeld>
void StepForces::on_all(Particles& p, double dem_dt, bool accumulate, MeanMotion* holding) {
  for (int i = 0; i < p.n; ++i)
    if (p.takes_part(i)) on<kHolding, kHeld>(p, i, dem_dt, accumulate, holding);
}

/// The common case: nothing held, not in set-up. What every step of every particle costs; the rest is left to
/// on().
void StepForces::plain(Particles& p, double dem_dt) {
  if (dem_dt != state_.decay_dt) find_decay(p, dem_dt);
  left_.resize(p.n);
  const PlainStep step{dem_dt, -density_, gravity_, by_group_.data(), int(by_group_.size())};
  const int left = add_plain_forces(p, step, state_.own_force, left_.data());
  for (int q = 0; q < left; ++q) on<false, false>(p, left_[q], dem_dt, true, nullptr);
}

void StepForces::find_decay(Particles& p, double dem_dt) {
  state_.decay_dt = dem_dt;
  for (int i = 0; i < p.n; ++i)
    if (p.takes_part(i)) p.step[i][kDecay] = decay(p.step[i][kDragCoefficient], 1 / p.mass[i]);
}

template <bool kHolding, bool kHeld>
void StepForces::on(Particles& p, int i, double dem_dt, bool accumulate, MeanMotion* holding) {
  const double lift = -density_;
  Vec3 c{0, 0, 0}, pressure{0, 0, 0};
  double *s = p.state[i], *impulse = p.step[i] + kImpulse;
  const double b = p.step[i][kDragCoefficient];
  const double sphere = sphere_volume(p.radius[i]), buoyancy = b > 0 ? lift * sphere : 0.0;
  double volume = 0, response = b;
  if (kHolding && b > 0) {
    holding->change_at(p.x[i], c, pressure);
    volume = state_.pressure_force ? sphere : 0.0;
    response = s[kResponse] / s[kVoidFraction];
  }
  const Vec3 gravity = by_group_.empty() ? gravity_ : gravity_of(p, i);
  Vec3 other, slip, steady;
  for (int d = 0; d < 3; ++d) {
    other[d] = p.f[i][d] + buoyancy * gravity[d];
    slip[d] = p.step[i][kStepVelocity + d] - c[d] - p.v[i][d];
    steady[d] = other[d] + s[kPressureForce + d] + volume * pressure[d];
  }
  const bool held = kHeld && p.held(i), held_in_part = kHeld && !held && p.some_held_in_part();
  const double k = held ? 0 : response * dem_dt / p.mass[i];
  const bool stiff = k > kStiff, goes_on = !accumulate && dem_dt == state_.last_dt && s[kKnown] != 0;
  Vec3 first, second;  // forces of the half kicks before and after this step's end
  if (stiff) {
    stiff_.push_back(i);
    Vec3 per_mass;
    for (int d = 0; d < 3; ++d) per_mass[d] = held_in_part && p.held(i, d) ? 0 : dem_dt / p.mass[i];
    stiff_forces(p, i, k / b, per_mass, steady, slip, accumulate, first, second);
  } else {
    double decay = mean_decay(k);
    if (goes_on && !held) decay /= 1 - 0.5 * b * dem_dt / p.mass[i] * decay;
    for (int d = 0; d < 3; ++d) first[d] = second[d] = (steady[d] + b * slip[d]) * decay;
  }
  if (goes_on && (kHolding || stiff)) take_up(s, other, first, second);
  if (held_in_part)
    for (int d = 0; d < 3; ++d)
      if (p.held(i, d)) first[d] = second[d] = steady[d] + b * slip[d];
  for (int d = 0; d < 3; ++d) {
    const double received = 0.5 * (first[d] + second[d]) - other[d];
    // Set-up computes the forces of t^n anew, for the half kick that begins the next step. That half kick's impulse was
    // counted at the last step already, with the force of then: only the difference is booked.
    impulse[d] += accumulate
                      ? received * dem_dt
                      : 0.5 * dem_dt * (received - s[kDragForce + d] - s[kPressureForce + d] - 0.5 * s[kLateForce + d]);
    s[kDragForce + d] = received - s[kPressureForce + d];
    s[kLateForce + d] = second[d] - first[d];
    if (!kHeld || !p.is_frozen(i, d)) p.f[i][d] = first[d];
  }
}

/// Half kicks of a stiff step such that v at whole steps is the exact answer and v between them, which moves the
/// particle, its exact mean. With G the steady force and w the slip at the mean velocity of the step that ends:
///   end of this step     first  = 2 (G + b w) [1 - (1 - phi)/(k phi)]
///   start of the next    second = 2 (G + b w_n) (1 - phi)/k,   w_n the slip at this step's end
/// b by the drag law at the mean slip of the step in question (that of the next one by iteration). k_per_b = k/b;
/// per_mass = D/m, 0 in a direction in which the particle is held.
void StepForces::stiff_forces(const Particles& p, int i, double k_per_b, const Vec3& per_mass, const Vec3& steady,
                              const Vec3& slip, bool ends_a_step, Vec3& first, Vec3& second) const {
  Vec3 end = slip, middle;
  if (ends_a_step) {
    // b at the mean slip; the longer the step, the nearer to the slip at its end, where it settles.
    double b = law_at(p, i, slip);
    for (int round = 0; round <= kStiffRounds; ++round) {
      const double k = k_per_b * b, phi = mean_decay(k), share = 1 - (1 - phi) / (k * phi);
      const double late = -std::expm1(-k * k);
      for (int d = 0; d < 3; ++d) {
        const double kick = (steady[d] + b * slip[d]) * share;
        first[d] = 2 * kick;
        end[d] = slip[d] - kick * per_mass[d];
        middle[d] = slip[d] + late * (end[d] - slip[d]);
      }
      if (round < kStiffRounds) b = std::sqrt(b * law_at(p, i, middle));
    }
  }
  // b and the mean slip depend on each other; where the drag goes with the square of the slip their product would swing
  // about the answer, and the geometric mean meets it.
  double b = law_at(p, i, end), share = 0;
  for (int round = 0; round <= kStiffRounds; ++round) {
    const double k = k_per_b * b, phi = mean_decay(k);
    share = (1 - phi) / k;
    if (round == kStiffRounds) break;
    double square = 0, mean_square = 0;
    for (int d = 0; d < 3; ++d) {
      const double F = steady[d] + b * end[d], last = end[d] - F * phi * per_mass[d];
      middle[d] = end[d] - F * share * per_mass[d];
      square += (end[d] * end[d] + end[d] * last + last * last) / 3;
      mean_square += 0.25 * (end[d] + last) * (end[d] + last);
    }
    // A drag that grows faster than the slip has a mean above that of the mean slip: mean of w^2 over mean of w.
    const double above = mean_square > 0 ? std::min(square / mean_square, 4.0 / 3) : 1.0;
    for (double& w : middle) w *= above;
    b = std::sqrt(b * law_at(p, i, middle));
  }
  for (int d = 0; d < 3; ++d) second[d] = 2 * (steady[d] + b * end[d]) * share;
  if (!ends_a_step) first = second;
}

/// The drag coefficient b_p for another slip than that of the last coupling, at the same eps and size.
double StepForces::law_at(const Particles& p, int i, const Vec3& slip) const {
  const double* s = p.state[i];
  const double magnitude = std::sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
  const double b_A =
      drag_coefficient(law_, s[kVoidFraction], 2 * p.radius[i], magnitude, density_, viscosity_, s[kSizeRatio]);
  return state_.pressure_force ? b_A : b_A / s[kVoidFraction];
}

void StepForces::finish_step(Particles& p) const {
  for (int i : stiff_)
    for (int d = 0; d < 3; ++d) p.f[i][d] += p.state[i][kLateForce + d];
}

}  // namespace twogrid
