#include "cfd/bodies/exact_turn.h"

#include <cmath>

namespace twogrid {

namespace {

/// A sum of doubles without rounding: parts of growing size that don't overlap.
class ExactSum {
 public:
  void add(double x) {
    int kept = 0;
    for (int q = 0; q < parts_; ++q) {
      const double sum = part_[q] + x, of_x = sum - part_[q];
      const double lost = (part_[q] - (sum - of_x)) + (x - of_x);
      if (lost != 0) part_[kept++] = lost;
      x = sum;
    }
    if (x != 0) part_[kept++] = x;
    parts_ = kept;
  }
  void add_product(double x, double y) {
    const double product = x * y;
    add(std::fma(x, y, -product));
    add(product);
  }
  int sign() const {
    const double largest = parts_ ? part_[parts_ - 1] : 0;
    return (largest > 0) - (largest < 0);
  }

 private:
  double part_[16];
  int parts_ = 0;
};

}  // namespace

int turn(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& p) {
  const double left = (b[0] - a[0]) * (p[1] - a[1]), right = (b[1] - a[1]) * (p[0] - a[0]), rounded = left - right;
  // Five roundings, each below 1.2e-16 of the products.
  if (std::abs(rounded) > 1e-15 * (std::abs(left) + std::abs(right))) return rounded > 0 ? 1 : -1;
  ExactSum sum;
  sum.add_product(b[0], p[1]), sum.add_product(-b[0], a[1]), sum.add_product(-a[0], p[1]);
  sum.add_product(-b[1], p[0]), sum.add_product(b[1], a[0]), sum.add_product(a[1], p[0]);
  return sum.sign();
}

}  // namespace twogrid
