// Flows with an analytic solution. Without these, a solver that is stable, conserves mass and looks right but is of
// first order (in space, or in dt alone), or has a wrong viscous coefficient, would pass.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Error of u of the decaying Taylor-Green vortex at t = T, n x n cells, in the plane normal to `thin`.
double taylor_green(int n, double dt, double T, int thin, bool implicit = false, bool history = true) {
  FluidSettings s;
  s.density = 1;
  s.viscosity = 0.05;
  s.convection = Convection::kCentral;
  s.implicit_viscosity = implicit ? Choice::kOn : Choice::kOff;
  s.pressure_rtol = 1e-9;
  s.dt = dt;
  const int a = (thin + 1) % 3, b = (thin + 2) % 3;
  std::array<std::vector<double>, 3> nodes;
  nodes[thin] = uniform(0, 2 * kPi / n, 1);
  nodes[a] = uniform(0, 2 * kPi, n);
  nodes[b] = uniform(0, 2 * kPi, n);
  CfdBox box(nodes, {true, true, true}, s);
  auto exact = [&](int d, double t) -> Function {
    const double decay = std::exp(-2 * s.viscosity * t);
    return [=](double x, double y, double z) {
      const double q[3] = {x, y, z};
      if (d == a) return std::sin(q[a]) * std::cos(q[b]) * decay;
      if (d == b) return -std::cos(q[a]) * std::sin(q[b]) * decay;
      return 0.0;
    };
  };
  auto u = box.face_field(), old = box.face_field();
  for (int d = 0; d < 3; ++d) box.set_faces(d, u[d], exact(d, 0)), box.set_faces(d, old[d], exact(d, -dt));
  CellField<FineGrid> p(box.eps_begin.box());
  box.set(p, [&](double x, double y, double z) {
    const double q[3] = {x, y, z};
    return 0.25 * (std::cos(2 * q[a]) + std::cos(2 * q[b]));
  });
  // Without history the first step is backward Euler, whose local error is of second order too; the exact u(-dt) would
  // bring in the space error at a rate of first order in dt.
  box.fluid->set_state(0, u, p, box.eps_begin, history ? dt : 0, old, box.eps_begin);
  const int steps = int(std::lround(T / dt));
  for (int k = 0; k < steps; ++k) box.step(dt);
  return box.face_error(a, exact(a, T));
}

}  // namespace

TEST(TaylorGreen, SecondOrderInSpace) {
  for (int thin : {0, 1, 2}) {
    const double e1 = taylor_green(16, 0.02, 0.4, thin), e2 = taylor_green(32, 0.01, 0.4, thin);
    if (::testing::UnitTest::GetInstance())
      std::printf("Taylor-Green, thin %d: error %.3e %.3e, order %.2f\n", thin, e1, e2, std::log2(e1 / e2));
    EXPECT_GT(std::log2(e1 / e2), 1.9);
    EXPECT_LT(e2, 5e-3);
  }
}

TEST(TaylorGreen, SecondOrderInTimeAlone) {
  for (bool implicit : {false, true}) {
    // The error of the space discretisation is that of a run with a far smaller step.
    auto run = [&](double dt) { return taylor_green(16, dt, 0.8, 2, implicit, false); };
    const double d1 = run(0.1), d2 = run(0.05), d3 = run(0.025);
    const double order = std::log2((d1 - d2) / (d2 - d3));
    std::printf("Taylor-Green in dt alone (%s viscosity): %.5e %.5e %.5e, order %.2f\n",
                implicit ? "implicit" : "explicit", d1, d2, d3, order);
    EXPECT_GT(order, 1.8);
  }
}

TEST(Poiseuille, SecondOrderAndRightFlow) {
  // Driven by a mean pressure gradient between no-slip walls, along x, y and z.
  for (int along : {0, 1, 2}) {
    const int across = (along + 1) % 3, thin = (along + 2) % 3;
    double error[2];
    for (int level = 0; level < 2; ++level) {
      const int n = level == 0 ? 8 : 16;
      FluidSettings s;
      s.density = 1;
      s.viscosity = 1;
      s.pressure_gradient[along] = -2;
      s.implicit_viscosity = Choice::kOn;
      s.dt = 0.05;
      s.side[2 * across] = s.side[2 * across + 1] = {condition(BoundaryKind::kNoSlip)};
      s.side[2 * thin] = s.side[2 * thin + 1] = {condition(BoundaryKind::kSlip)};
      std::array<bool, 3> periodic{false, false, false};
      periodic[along] = true;
      std::array<std::vector<double>, 3> nodes;
      nodes[along] = uniform(0, 1, 2), nodes[across] = uniform(0, 1, n), nodes[thin] = uniform(0, 1, 1);
      CfdBox box(nodes, periodic, s);
      for (int k = 0; k < 60; ++k) box.step(0.05);
      error[level] = box.face_error(along, [&](double x, double y, double z) {
        const double q[3] = {x, y, z};
        return q[across] * (1 - q[across]);
      });
    }
    std::printf("Poiseuille along %d: error %.3e %.3e, order %.2f\n", along, error[0], error[1],
                std::log2(error[0] / error[1]));
    EXPECT_GT(std::log2(error[0] / error[1]), 1.9);
    EXPECT_LT(error[1], 2e-3);
  }
}
