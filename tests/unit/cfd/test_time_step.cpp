// The Courant number of even flows along one axis, two and three: the sum over the directions, in the narrowest cells.
// Without this test a direction could be left out of it, and steps along that one would be too long.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

TEST(TimeStep, CourantNumberIsTheSumOverTheDirections) {
  const Vec3 speed{0.7, -0.5, 0.9};
  for (int axes = 1; axes < 8; ++axes) {
    FluidSettings s;
    s.density = 1.2, s.viscosity = 1e-3, s.cfl = 0.4;
    const std::array<std::vector<double>, 3> nodes{graded_nodes(0, 1, 8, 1.2, true), uniform(0, 1, 6),
                                                   graded_nodes(0, 1, 10, 1.1, true)};
    double rate = 0;
    for (int d = 0; d < 3; ++d) {
      s.initial_velocity[d] = axes & 1 << d ? speed[d] : 0;
      double narrowest = 1;
      for (std::size_t i = 1; i < nodes[d].size(); ++i) narrowest = std::min(narrowest, nodes[d][i] - nodes[d][i - 1]);
      rate += std::abs(s.initial_velocity[d]) / narrowest;
    }
    CfdBox box(nodes, {true, true, true}, s);
    const double interval = 1.0;
    const FluidReport r = box.step(interval);
    EXPECT_NEAR(r.cfl, r.dt * rate, 1e-9) << "axes " << axes;
    EXPECT_NEAR(r.dt * r.steps, interval, 1e-9);
    EXPECT_LE(r.cfl, s.cfl);
    EXPECT_GT(r.cfl, 0.6 * s.cfl) << "axes " << axes;  // no shorter than needed
  }
}
