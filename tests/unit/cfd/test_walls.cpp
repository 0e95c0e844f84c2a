// Couette flow between two walls that move, along all axes and in cells of different widths: the profile is linear and
// the scheme holds it exactly. Without this test a wall that drags the fluid along with half its velocity would only be
// noticed by the cavity, among the slow verification tests.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

TEST(Walls, ThatMoveDragTheFluidAlong) {
  for (int along : {0, 1, 2})
    for (int step : {1, 2}) {
      const int across = (along + step) % 3, third = (along + 3 - step) % 3;
      const double below = -0.3, above = 0.7, height = 0.5;
      FluidSettings s;
      s.density = 1.2, s.viscosity = 0.5, s.implicit_viscosity = Choice::kOn, s.dt = 10;
      Vec3 low{0, 0, 0}, high{0, 0, 0};
      low[along] = below, high[along] = above;
      s.side[2 * across] = {condition(BoundaryKind::kNoSlip, low)};
      s.side[2 * across + 1] = {condition(BoundaryKind::kNoSlip, high)};
      s.side[2 * third] = s.side[2 * third + 1] = {condition(BoundaryKind::kSlip)};
      std::array<bool, 3> periodic{false, false, false};
      periodic[along] = true;
      std::array<std::vector<double>, 3> nodes;
      nodes[along] = uniform(0, 1, 4), nodes[across] = graded_nodes(0, height, 9, 1.2), nodes[third] = uniform(0, 1, 4);
      CfdBox box(nodes, periodic, s);
      for (int n = 0; n < 20; ++n) box.step(10);
      double worst = 0;
      for_each(box.faces(along), [&](int i, int j, int k) {
        const double share = box.face(along, i, j, k)[across] / height;
        worst = std::max(worst, std::abs(box.fluid->velocity()[along](i, j, k) - (below + (above - below) * share)));
      });
      EXPECT_LT(worst, 1e-7) << "along " << along << ", across " << across;
    }
}
