// The means over an interval of several steps, in a flow whose every step is known: a uniform one that an imposed
// gradient speeds up evenly, which each scheme in time follows exactly. The drag is implicit, so it sees the velocity at
// the end of each step: the mean of N steps is that half a step later than the middle of the interval. Without this test
// a mean of the old velocities would pass, as it differs by one part in N.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

TEST(IntervalMeans, OfAFlowThatSpeedsUpEvenly) {
  for (int steps : {1, 2, 7}) {
    const double interval = 0.21, density = 1.2;
    const Vec3 begin{0.3, -0.2, 0.1}, gradient{-0.6, 0.24, 0.12};
    FluidSettings s;
    s.density = density, s.viscosity = 0.02, s.dt = interval / steps * (1 + 1e-9);
    s.initial_velocity = begin, s.pressure_gradient = gradient;
    CfdBox box({uniform(0, 1, 6), uniform(0, 1, 6), graded_nodes(0, 1, 6, 1.1, true)}, {true, true, true}, s);
    box.fluid->keep_pressure_gradient();
    for (int n = 0; n < 3; ++n) {
      const FluidReport r = box.step(interval);
      ASSERT_EQ(r.steps, steps);
      for (int d = 0; d < 3; ++d) {
        const double a = -gradient[d] / density, end = begin[d] + a * interval * (n + 1);
        const double mean = end - a * (interval / steps) * 0.5 * (steps - 1);
        for_each(box.faces(d), [&](int i, int j, int k) {
          EXPECT_NEAR(box.fluid->velocity()[d](i, j, k), end, 1e-12);
          EXPECT_NEAR(box.fluid->mean_velocity()[d](i, j, k), mean, 1e-12);
          EXPECT_NEAR(box.fluid->mean_pressure_gradient()[d](i, j, k), gradient[d], 1e-11);
        });
      }
    }
  }
}
