// Exponential decay of a slip over a step, k = step over response time.
#pragma once

#include <cmath>

namespace twogrid {

/// k above which a step counts as stiff: below, the error of a constant drag coefficient is under 1e-3.
constexpr double kStiff = 0.02;

/// phi(k) = (1 - e^-k)/k, the mean of e^-s over s in [0, k], for k up to kStiff to 1e-14.
inline double mean_decay_series(double k) {
  return 1 - k * (1.0 / 2 - k * (1.0 / 6 - k * (1.0 / 24 - k * (1.0 / 120 - k * (1.0 / 720)))));
}
/// The same for any k.
inline double mean_decay(double k) {
  return k <= kStiff ? mean_decay_series(k) : -std::expm1(-k) / k;
}

}  // namespace twogrid
