// Flows that bodies in the grid bound, whose solutions are known (cfd/bodies, cfd/momentum/cut_links.h). Without these, a
// wall that is a cell too near, an area that counts twice, stress through a wall, friction that hangs on where the wall
// lies on the grid, or an axis taken for another would pass.
#include <gtest/gtest.h>

#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

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

/// Error of the flow through pipes of radius R (m) along an axis, with a rod of radius r inside or none; N cells a metre.
double pipe_error(int along, int N, double R, double r, int salt) {
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  FluidSettings s = creeping(10);
  s.pressure_gradient[along] = -1;
  s.side[2 * along].clear(), s.side[2 * along + 1].clear();
  Vec3 centre{0, 0, 0}, axis{0, 0, 0};
  axis[along] = 1;
  centre[e] = 0.5 + (random_number(2 * salt) - 0.5) / N, centre[f] = 0.5 + (random_number(2 * salt + 1) - 0.5) / N;
  s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, R, FluidIs::kInside), "pipe")};
  if (r > 0) s.bodies.push_back(body(std::make_shared<CylinderShape>(centre, axis, r, FluidIs::kOutside), "rod"));
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> periodic{false, false, false};
  periodic[along] = true;
  nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 1, N), nodes[along] = uniform(0, 2.0 / N, 2);
  CfdBox box(nodes, periodic, s);
  const int steps = until_steady(box, along, s.dt, 1e-7, 50);
  EXPECT_GT(steps, 0);
  const double core = r > 0 ? (R * R - r * r) * (R * R - r * r) / std::log(R / r) : 0;
  const double error = superficial(box, along) / (kPi / 8 * (std::pow(R, 4) - std::pow(r, 4) - core)) - 1;
  // The walls carry what drives the flow.
  double open = 0, force = 0;
  for_each(box.faces(along), [&](int i, int j, int k) { open += box.fluid->measures().open_volume(along, i, j, k); });
  for (const BodyForce& b : box.fluid->body_forces()) force += b.force()[along];
  const double balance = force / box.sum(open) - 1;
  report("%s along %d, %.1f cells across, place %d: flow %+.3f %%, force %+.1e, %d steps\n", r > 0 ? "annulus" : "pipe",
         along, N * (r > 0 ? R - r : 2 * R), salt, 100 * error, balance, steps);
  EXPECT_LT(std::abs(balance), 1e-6);
  return error;
}

/// Error of the flow rate of Poiseuille flow in ducts at an angle to the grid; density 0: creeping.
double oblique_duct(int thin, int N, double sine, double cosine, double density, int salt) {
  const int x = (thin + 1) % 3, y = (thin + 2) % 3;
  const double Lx = 1 / sine, Ly = 1 / cosine, half = 0.3;  // period 1
  FluidSettings s = creeping(10);
  if (density > 0) {
    s.density = density;
    s.convection = Convection::kCentral;
    s.dt = 0, s.cfl = 0.6;
  }
  s.pressure_gradient[x] = -cosine, s.pressure_gradient[y] = -sine;
  s.bodies = {body(std::make_shared<ObliqueDucts>(x, y, sine, cosine, 1.0, random_number(salt) / N, half), "duct")};
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> periodic{true, true, true};
  periodic[thin] = false;
  for (int d : {x, y}) s.side[2 * d].clear(), s.side[2 * d + 1].clear();
  nodes[thin] = uniform(0, 1.0 / N, 1);
  nodes[x] = uniform(0, Lx, int(std::lround(Lx * N))), nodes[y] = uniform(0, Ly, int(std::lround(Ly * N)));
  CfdBox box(nodes, periodic, s);
  const int steps =
      until_steady(box, x, density > 0 ? 0.1 * density : 10, density > 0 ? 1e-5 : 1e-6, density > 0 ? 12 : 60);
  EXPECT_GT(steps, 0);
  const double U = 2.0 / 3 * half * half * half, error = std::hypot(superficial(box, x), superficial(box, y)) / U - 1,
               across = superficial(box, x) * sine - superficial(box, y) * cosine;
  report("duct across %d at %.1f degrees, %.1f cells across, density %g: flow %+.3f %%, across it %.1e, %d steps\n",
         thin, std::asin(sine) * 180 / kPi, 2 * half * N, density, 100 * error, across / U, steps);
  EXPECT_LT(std::abs(across), 1e-5 * U);
  return error;
}

}  // namespace

TEST(Bodies, Pipe) {
  double coarse = 0;
  for (int along : {0, 1, 2}) {
    for (int salt = 0; salt < 3; ++salt) {
      const double error = std::abs(pipe_error(along, 16, 0.42, 0, salt));
      EXPECT_LT(error, 0.01);
      coarse = std::max(coarse, error);
    }
    const double fine = std::abs(pipe_error(along, 32, 0.42, 0, along));
    EXPECT_LT(fine, 0.003);
    EXPECT_LT(fine, coarse / std::pow(2, 1.8));
  }
}

TEST(Bodies, Annulus) {
  for (int along : {0, 1, 2}) EXPECT_LT(std::abs(pipe_error(along, 30, 0.42, 0.357 * 0.42, along)), 0.015);
}

/// At 30 degrees the error falls with the width of the cells only: what crosses from row to row passes slivers.
TEST(Bodies, ObliqueDuct) {
  for (int thin : {0, 1, 2}) {
    EXPECT_LT(std::abs(oblique_duct(thin, 12, std::sqrt(0.5), std::sqrt(0.5), 0, thin)), 0.01);
    EXPECT_LT(std::abs(oblique_duct(thin, 24, std::sqrt(0.5), std::sqrt(0.5), 0, thin)), 0.003);
    const double coarse = std::abs(oblique_duct(thin, 12, 0.5, std::sqrt(0.75), 0, thin)),
                 fine = std::abs(oblique_duct(thin, 24, 0.5, std::sqrt(0.75), 0, thin));
    EXPECT_LT(fine, 0.01);
    EXPECT_LT(fine, 0.6 * coarse);
  }
}

/// Convection along the grid's diagonal leaves parallel flow as it is (Reynolds number 80 by the mean velocity and the
/// duct's width).
TEST(Bodies, ConvectionInAnObliqueDuct) {
  const double still = oblique_duct(2, 12, std::sqrt(0.5), std::sqrt(0.5), 0, 2),
               fast = oblique_duct(2, 12, std::sqrt(0.5), std::sqrt(0.5), 3000, 2);
  EXPECT_NEAR(fast, still, 2e-3);
}
