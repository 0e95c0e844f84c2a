// Ducts at an angle to the grid, for verification.
#pragma once

#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

namespace twogrid {

/// Between two parallel planes |s| < half, s = x sin - y cos (d: directions of x and y), and all images of them a period
/// apart.
class ObliqueDucts : public SolidShape {
 public:
  ObliqueDucts(int x, int y, double sine, double cosine, double period, double centre, double half)
      : normal_{0, 0, 0}, period_(period), centre_(centre), half_(half) {
    normal_[x] = sine, normal_[y] = -cosine;
  }
  double first_crossing(const Vec3& x, int d, double length) const override {
    const double s = height(x), change = normal_[d] * length;
    double first = kNone;
    for (int image = -3; image <= 3; ++image)
      for (double wall : {-half_, half_}) {
        const double share = (wall + image * period_ - s) / change;
        if (share >= 0 && share <= 1) first = std::min(first, share);
      }
    return first;
  }
  double distance(const Vec3& x, double, Vec3& nearest) const override {
    const double s = height(x), out = (s > 0 ? 1 : -1) * (half_ - std::abs(s));
    for (int d = 0; d < 3; ++d) nearest[d] = x[d] + out * normal_[d];
    return std::abs(out);
  }
  Side side(const Vec3& x) const override { return std::abs(height(x)) < half_ ? Side::kFluid : Side::kSolid; }

 private:
  double height(const Vec3& x) const {
    const double s = normal_[0] * x[0] + normal_[1] * x[1] + normal_[2] * x[2] - centre_;
    return s - period_ * std::round(s / period_);
  }

  Vec3 normal_;
  double period_, centre_, half_;
};

/// Periodic in the duct's plane, one cell deep across it; N cells to a period.
struct Duct {
  static constexpr double half = 0.3;  // of a period of 1
  int thin, x, y, N;
  double sine, cosine;
  FluidSettings s;

  Duct(int thin_, int N_, double degrees, int salt)
      : thin(thin_),
        x((thin_ + 1) % 3),
        y((thin_ + 2) % 3),
        N(N_),
        sine(std::sin(degrees * kPi / 180)),
        cosine(std::cos(degrees * kPi / 180)),
        s(creeping(10)) {
    s.pressure_gradient[x] = -cosine, s.pressure_gradient[y] = -sine;
    s.bodies = {body(std::make_shared<ObliqueDucts>(x, y, sine, cosine, 1.0, random_number(salt) / N, half), "duct")};
    for (int d : {x, y}) s.side[2 * d].clear(), s.side[2 * d + 1].clear();
  }
  CfdBox box() const {
    std::array<std::vector<double>, 3> nodes;
    std::array<bool, 3> periodic{true, true, true};
    periodic[thin] = false;
    nodes[thin] = uniform(0, 1.0 / N, 1);
    nodes[x] = uniform(0, 1 / sine, int(std::lround(N / sine)));
    nodes[y] = uniform(0, 1 / cosine, int(std::lround(N / cosine)));
    return CfdBox(nodes, periodic, s);
  }
};

}  // namespace twogrid
