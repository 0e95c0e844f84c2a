// Sums that don't depend on the order of their terms: every term is rounded once to a multiple of a unit (a power of
// two) and the multiples are added as 64-bit integers. The unit must be the same on all ranks; it follows from maxima
// only, since those don't depend on the order of reduction either.
//
// A single value has at most 2^50 units, so that it and its parts are exact as doubles too: parts are made by
// arithmetic of doubles (four at a time, see stencil.h) and turned into integers only where they are added.
#pragma once

#include <cmath>

#include "cfd/parallel/vectorised.h"

namespace twogrid {

/// Added to a double of size below 2^51 and subtracted again, it leaves the nearest whole number: the sum is so large
/// that its last place is worth one. Before the subtraction that whole number is the sum's bits, read as an integer,
/// less kWholeBits.
constexpr double kWhole = 6755399441055744.0;           // 1.5 2^52
constexpr long long kWholeBits = 0x4338000000000000LL;  // of the same

class FixedPoint {
 public:
  FixedPoint() = default;
  /// Sums of up to `terms` values of at most |largest| fit: unit = 2^(ceil log2 largest + ceil log2 terms) 2^-62, and
  /// at least 2^-50 of the largest.
  FixedPoint(double largest, double terms) {
    if (!(largest > 0)) return;
    int a = 0, b = 0;
    std::frexp(largest, &a);  // largest <= 2^a
    std::frexp(terms, &b);
    b = b > 12 ? b : 12;
    unit_ = std::ldexp(1.0, a + b - 62);
    inverse_ = std::ldexp(1.0, 62 - a - b);
  }
  /// Nearest multiple, a whole number. 0 for what is not finite, or far out of the range of the constructor: a particle
  /// with such a number ends the run, but not before all have been looked at, and sums must not overflow until then.
  double whole(double q) const {
    const double w = nearest(q);
    return std::abs(w) < 0x1p51 ? w : 0.0;
  }
  /// Whole numbers of four values, which are multiplied by their units' per_unit() already; the same of what is not finite
  /// or far out of range.
  static void to_whole(Four& values) {
    const Four w = (values + kWhole) - kWhole;
    Four size;
    size_of(w, size);
    values = (Four)((FourIntegers)w & (size < 0x1p51));
  }
  /// As whole(), an integer.
  long long quantise(double q) const {
    const double w = nearest(q);
    return std::abs(w) < 0x1p62 ? static_cast<long long>(w) : 0;
  }
  double value(long long m) const { return double(m) * unit_; }
  double unit() const { return unit_; }
  double per_unit() const { return inverse_; }

 private:
  double nearest(double q) const { return (q * inverse_ + kWhole) - kWhole; }

  double unit_ = 1, inverse_ = 1;
};

}  // namespace twogrid
