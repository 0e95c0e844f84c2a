// What a particle leaves behind at a coupling, against motions that are known: a way across a periodic side is the short
// one, a velocity that changes evenly is extrapolated exactly to the interval's end, and a sphere that the drag sped up
// from rest in steady fluid has received just what the implicit drag says. Without this test a way of a whole period
// would pass as long as no test's particles cross a side within an interval that is looked at so closely.
#include <gtest/gtest.h>

#include <cmath>

#include "coupling/forces/interval_end.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr Vec3 kPeriod{1.0, 0, 2.0};  // y has sides

/// Ends an interval of length D for all bodies.
std::vector<ImplicitDrag> end(Bodies& bodies, double D, double extrapolation, std::vector<FourNumbers>& flux) {
  Particles p = bodies.view();
  std::vector<int> who;
  for (int i = 0; i < p.n; ++i) who.push_back(i);
  for (int d = 0; d < 3; ++d) p.period[d] = kPeriod[d];
  std::vector<ImplicitDrag> drag;
  Survey survey;
  end_of_interval(p, who, {D, 0, extrapolation, nullptr}, drag, flux, survey);
  return drag;
}

TEST(IntervalEnd, PathsAcrossPeriodicSidesAndVelocitiesAtTheEnd) {
  Bodies bodies;
  std::vector<Vec3> begin, speed, change;  // velocity at time 0 (m/s), acceleration (m/s2)
  for (int q = 0; q < 40; ++q) {
    begin.push_back({0.5 + 0.5 * std::sin(1.0 + q), 0.5, 1 + std::cos(2.3 * q)});
    speed.push_back({3 * std::cos(0.7 * q), 0.1 * std::sin(q), -5 * std::sin(0.9 * q)});
    change.push_back({2 * std::sin(0.4 * q), 0.2, 4 * std::cos(1.7 * q)});
    bodies.add(begin[q], 0.01, 1000, speed[q], q + 1);
  }
  double t = 0, before = 0;
  int crossed = 0;
  for (double D : {0.05, 0.03, 0.08, 0.06}) {
    t += D;
    std::vector<Vec3> from(begin.size());
    for (std::size_t q = 0; q < begin.size(); ++q)
      for (int d = 0; d < 3; ++d) {
        from[q][d] = bodies.x[q][d];
        double x = begin[q][d] + speed[q][d] * t + 0.5 * change[q][d] * t * t;
        if (kPeriod[d] > 0) x -= kPeriod[d] * std::floor(x / kPeriod[d]);
        bodies.x[q][d] = x;
        crossed += std::abs(x - from[q][d]) > 0.5;
      }
    std::vector<FourNumbers> flux;
    end(bodies, D, before > 0 ? D / (D + before) : 0, flux);
    for (std::size_t q = 0; q < begin.size() && before > 0; ++q)
      for (int d = 0; d < 3; ++d) {
        const double mean = speed[q][d] + change[q][d] * (t - 0.5 * D), now = speed[q][d] + change[q][d] * t;
        EXPECT_NEAR(bodies.state[q][kPathVelocity + d], mean, 1e-12) << "particle " << q << ", direction " << d;
        EXPECT_DOUBLE_EQ(bodies.state[q][kPosition + d], bodies.x[q][d]);
        if (t > 0.1) {
          EXPECT_NEAR(flux[q].at[d], now, 1e-12) << "particle " << q << ", direction " << d;
        }
      }
    before = D;
  }
  EXPECT_GT(crossed, 20);
}

TEST(IntervalEnd, ImplicitDragIsWhatASphereFromRestReceives) {
  for (double k : {1e-3, 0.5, 20.0}) {
    Bodies bodies;
    const Vec3 u{1.2, -0.3, 0.7};
    bodies.add({0.5, 0.5, 0.5}, 0.01, 1000, {0, 0, 0}, 1);
    const double m = bodies.mass[0], b = 0.4, D = k * m / b, gained = -std::expm1(-k);
    for (int d = 0; d < 3; ++d) {
      bodies.v[0][d] = u[d] * gained;
      bodies.state[0][kFluidVelocity + d] = u[d];
      bodies.state[0][kPosition + d] = 0.5;
      bodies.step[0][kImpulse + d] = m * u[d] * gained;
    }
    bodies.state[0][kResponse] = b, bodies.state[0][kKnown] = 1;
    std::vector<FourNumbers> flux;
    const std::vector<ImplicitDrag> drag = end(bodies, D, 0, flux);
    const double response = m * gained / D;
    EXPECT_NEAR(drag[0].given[3], response, 1e-13 * response);
    // Nothing is left over once the fluid has been as it was seen.
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(drag[0].given[d], 0, 1e-13 * response);
      EXPECT_DOUBLE_EQ(drag[0].seen[d], u[d]);
    }
  }
}

}  // namespace
}  // namespace twogrid_test
