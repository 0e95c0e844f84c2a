// An even flow that enters through one side and leaves through the opposite one at an angle stays even: what a side
// hands on of the velocity along it is what comes in and goes out. Without this test the outermost sides could carry any
// share of it, for inlets of other tests blow straight in.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

TEST(ObliqueFlow, StaysEvenBetweenInletAndOutlet) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
    for (int d : {0, 1, 2})
      for (bool upwards : {true, false}) {
        Vec3 u{0.4, -0.3, 0.2};
        u[d] = upwards ? 0.8 : -0.8;
        FluidSettings s;
        s.density = 1.2, s.viscosity = 1e-3, s.convection = scheme, s.initial_velocity = u, s.pressure_rtol = 1e-12;
        s.side[2 * d + !upwards] = {condition(BoundaryKind::kInlet, u)};
        s.side[2 * d + upwards] = {condition(BoundaryKind::kPressure)};
        std::array<bool, 3> periodic{true, true, true};
        periodic[d] = false;
        std::array<std::vector<double>, 3> nodes{uniform(0, 1, 6), uniform(0, 1, 6), uniform(0, 1, 6)};
        nodes[d] = graded_nodes(0, 1, 8, 1.1);
        CfdBox box(nodes, periodic, s);
        for (int n = 0; n < 10; ++n) box.step(0.1);
        double worst = 0;
        for (int c = 0; c < 3; ++c)
          for_each(box.faces(c), [&](int i, int j, int k) {
            worst = std::max(worst, std::abs(box.fluid->velocity()[c](i, j, k) - u[c]));
          });
        EXPECT_LT(box.largest(worst), 1e-9) << "along " << d;
      }
}
