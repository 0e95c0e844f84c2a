// Sums that don't depend on the order of their terms: every term is rounded once to a multiple of a unit (a power of
// two) and the multiples are added as 64-bit integers. The unit must be the same on all ranks; it follows from maxima
// only, since those don't depend on the order of reduction either.
#pragma once

#include <cmath>

namespace twogrid {

class FixedPoint {
 public:
  FixedPoint() = default;
  /// Sums of up to `terms` values of at most |largest| fit: unit = 2^(ceil log2 largest + ceil log2 terms) 2^-62.
  FixedPoint(double largest, double terms) {
    if (!(largest > 0)) return;
    int a = 0, b = 0;
    std::frexp(largest, &a);  // largest <= 2^a
    std::frexp(terms, &b);
    unit_ = std::ldexp(1.0, a + b - 62);
    inverse_ = std::ldexp(1.0, 62 - a - b);
  }
  /// Nearest multiple; q must be within the range of the constructor.
  long long quantise(double q) const {
    const double m = q * inverse_;
    return static_cast<long long>(m < 0 ? m - 0.5 : m + 0.5);
  }
  double value(long long m) const { return double(m) * unit_; }
  double unit() const { return unit_; }

 private:
  double unit_ = 1, inverse_ = 1;
};

}  // namespace twogrid
