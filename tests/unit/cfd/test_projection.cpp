// What the projection owes whatever the solvers' tolerances and the viscosity: the domain's balance of volume to
// rounding, and the pressure that the momentum equation wants.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

}  // namespace

// A pressure solver that stops early leaves a part of continuity; the outlets let it out. Without this test fluid could
// be lost or made in every step, by as much as the tolerance is wide.
TEST(Projection, OutletsBalanceTheDomainAtAnyTolerance) {
  FluidSettings s;
  s.density = 1.2, s.viscosity = 1e-2, s.pressure_rtol = 1e-2;
  s.side[4] = {condition(BoundaryKind::kInlet, {0, 0, 0.6})};
  s.side[1] = s.side[5] = {condition(BoundaryKind::kPressure)};
  s.side[0] = {condition(BoundaryKind::kNoSlip)};
  CfdBox box({graded_nodes(0, 1, 10, 1.1), uniform(0, 1, 8), graded_nodes(0, 2, 16, 1.05)}, {false, true, false}, s);
  double t = 0;
  for (int n = 0; n < 12; ++n) {
    t += 0.03;
    box.set(box.eps_end, [t](double x, double y, double z) {
      return 0.7 + 0.2 * std::sin(4 * x + 2 * t) * std::cos(2 * kPi * y) * std::cos(3 * z - 5 * t) - 0.3 * t;
    });
    const FluidReport r = box.step(0.03);
    box.eps_begin = box.eps_end;
    EXPECT_GT(r.inflow, 0.5);
    EXPECT_NEAR(r.inflow + r.displaced, r.outflow, 1e-13) << "interval " << n;
  }
}

// A force per volume that is a gradient moves nothing: the pressure takes it all in the first step, however viscous the
// fluid. Without this test the part of the pressure that implicit viscosity wants, 4/3 mu div u*, could have another
// factor: the error goes with mu dt/h^2, and comes back in every step.
TEST(Projection, PressureTakesUpAGradientAtOnce) {
  for (double mu : {0.0012, 1.2, 120.0}) {
    FluidSettings s;
    s.density = 1.2, s.viscosity = mu, s.implicit_viscosity = Choice::kOn, s.pressure_rtol = 1e-13, s.dt = 1;
    CfdBox box({uniform(0, 1, 8), uniform(0, 1.5, 10), uniform(0, 0.8, 6)}, {true, true, true}, s);
    const Function potential = [](double x, double y, double z) {
      return 1e-6 * (std::sin(2 * kPi * x) * std::cos(4 * kPi * y / 1.5) + std::cos(2 * kPi * (x + z / 0.8)));
    };
    Interphase exchange;
    exchange.source = box.face_field();
    for (int d = 0; d < 3; ++d) {
      const double h = box.grid.axis[d].width(0);
      box.set_faces(d, exchange.source[d], [&](double x, double y, double z) {
        Vec3 low{x, y, z}, high{x, y, z};
        low[d] -= 0.5 * h, high[d] += 0.5 * h;
        return (potential(high[0], high[1], high[2]) - potential(low[0], low[1], low[2])) / h;
      });
    }
    for (int n = 0; n < 3; ++n) {
      box.step(0.1, exchange);
      EXPECT_LT(box.pressure_error(potential, true), 1e-6 * 1e-6) << "mu " << mu << ", interval " << n;
      for (int d = 0; d < 3; ++d)
        EXPECT_LT(box.face_error(d, [](double, double, double) { return 0.0; }), 1e-13) << "mu " << mu;
    }
  }
}
