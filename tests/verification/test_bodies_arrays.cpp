// Creeping flow through arrays of cylinders and of spheres, and the force on a body: what drives the flow, and what the
// fluid loses. Without these, a wrong drag of round bodies, forces that miss a part, or momentum that goes nowhere would
// pass.
#include <gtest/gtest.h>

#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

/// F/(mu U) of a square array of cylinders of a period of 1 m, by the flow and by the force on the body.
void cylinders(int along, int thin, int N, double Phi, double exact, double wanted, int salt) {
  const int across = 3 - along - thin;
  FluidSettings s = creeping(0.02);
  s.pressure_gradient[along] = -1;
  Vec3 centre{0, 0, 0}, axis{0, 0, 0};
  axis[thin] = 1;
  centre[along] = 0.5 + (random_number(2 * salt) - 0.5) / N;
  centre[across] = 0.5 + (random_number(2 * salt + 1) - 0.5) / N;
  s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, std::sqrt(Phi / kPi), FluidIs::kOutside))};
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> periodic{true, true, true};
  periodic[thin] = false;
  for (int d : {along, across}) s.side[2 * d].clear(), s.side[2 * d + 1].clear();
  nodes[along] = nodes[across] = uniform(0, 1, N), nodes[thin] = uniform(0, 1.0 / N, 1);
  CfdBox box(nodes, periodic, s);
  const int steps = until_steady(box, along, s.dt, 1e-5, 300);
  EXPECT_GT(steps, 0);
  const double drag = 1 / superficial(box, along), V = 1.0 / N;
  const BodyForce& F = box.fluid->body_forces()[0];
  const double open = open_volume(box);
  report(
      "cylinders along %d, across %d, Phi %.2f: F/(mu U) %.3f, %+.2f %%; force %+.1e, friction's share %.3f, torque "
      "%.1e, "
      "%d steps\n",
      along, thin, Phi, drag, 100 * (drag / exact - 1), F.force()[along] / open - 1,
      F.friction[along] / F.force()[along], F.torque[thin] / V, steps);
  EXPECT_LT(std::abs(drag / exact - 1), wanted);
  EXPECT_NEAR(F.force()[along], open, 1e-3 * V);
}

/// Drag of spheres of radius R in a cubic lattice of a period of 1 m over 6 pi mu R U; a quarter of the period.
void spheres(int along, int N, double R, double exact, double wanted) {
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  FluidSettings s = creeping(0.02);
  s.pressure_gradient[along] = -1;
  s.side[2 * along].clear(), s.side[2 * along + 1].clear();
  Vec3 centre{0, 0, 0};
  centre[along] = 0.5;
  s.bodies = {body(std::make_shared<SphereShape>(centre, R, FluidIs::kOutside))};
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> periodic{false, false, false};
  periodic[along] = true;
  nodes[along] = uniform(0, 1, N), nodes[e] = nodes[f] = uniform(0, 0.5, N / 2);
  CfdBox box(nodes, periodic, s);
  const int steps = until_steady(box, along, s.dt, 1e-5, 300);
  EXPECT_GT(steps, 0);
  const double drag = 1 / (6 * kPi * R * superficial(box, along));
  report("spheres along %d, R %.2f: K %.3f, %+.2f %%, %d steps\n", along, R, drag, 100 * (drag / exact - 1), steps);
  EXPECT_LT(std::abs(drag / exact - 1), wanted);
}

}  // namespace

// Sangani & Acrivos (1982), table 1.
TEST(BodiesInArrays, Cylinders) {
  cylinders(0, 2, 32, 0.05, 15.56, 0.01, 1);
  cylinders(1, 0, 32, 0.1, 24.83, 0.01, 2);
  cylinders(2, 1, 32, 0.2, 51.53, 0.01, 3);
  cylinders(1, 2, 32, 0.3, 102.90, 0.01, 4);
  cylinders(0, 1, 32, 0.4, 217.89, 0.01, 5);
}

// Zick & Homsy (1982).
TEST(BodiesInArrays, Spheres) {
  spheres(2, 32, std::cbrt(0.125 * 3 / (4 * kPi)), 4.292, 0.03);
  spheres(0, 32, std::cbrt(0.216 * 3 / (4 * kPi)), 7.442, 0.03);
  spheres(1, 32, std::cbrt(0.45 * 3 / (4 * kPi)), 28.1, 0.03);
}
