// Flows that viscosity alone decides, against their solutions: between near walls, from rest, and on stretched grids.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

}  // namespace

TEST(GapFriction, IsThatOfAHeleShawCell) {
  for (int thin : {0, 1, 2}) {
    const int along = (thin + 1) % 3, across = (thin + 2) % 3;
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.3, s.gap_friction = true, s.dt = 1e9;
    s.pressure_gradient[along] = -5;
    s.side[2 * thin] = s.side[2 * thin + 1] = {condition(BoundaryKind::kSlip)};
    std::array<bool, 3> periodic{true, true, true};
    periodic[thin] = false;
    const double W = 0.2;
    std::array<std::vector<double>, 3> nodes;
    nodes[thin] = uniform(0, W, 1), nodes[along] = uniform(0, 1, 4), nodes[across] = uniform(0, 1, 4);
    CfdBox box(nodes, periodic, s);
    for (int k = 0; k < 60; ++k) box.step(0.02);
    const double wanted = 5 * W * W / (12 * 0.3);
    const double error = box.face_error(along, [&](double, double, double) { return wanted; });
    if (thin == 0) report("gap friction: mean velocity off by %.1e\n", error / wanted);
    EXPECT_LT(error, 1e-9 * wanted);
  }
}

TEST(ImplicitViscosity, ChannelStartUpAtLargeViscousNumbers) {
  // Flow from rest between walls 1 apart under a constant gradient (Batchelor 1967, section 4.3):
  // u = G/(2 mu) y(1-y) - 4 G/(mu pi^3) sum over odd m of sin(m pi y) exp(-m^2 pi^2 nu t)/m^3.
  for (double dt : {0.1, 0.005}) {
    const int n = 32;
    const double nu = 1;
    FluidSettings s;
    s.density = 2, s.viscosity = nu * s.density, s.dt = dt;
    s.pressure_gradient[0] = -2 * s.viscosity;
    s.side[kYlo] = s.side[kYhi] = {condition(BoundaryKind::kNoSlip)};
    s.side[kZlo] = s.side[kZhi] = {condition(BoundaryKind::kSlip)};
    CfdBox box({uniform(0, 1, 2), uniform(0, 1, n), uniform(0, 1, 1)}, {true, false, false}, s);
    double worst = 0, t = 0;
    for (int k = 0; t < 1 - 1e-9; ++k) {
      box.step(dt);
      t += dt;
      const double e = box.face_error(0, [&](double, double y, double) {
        double u = y * (1 - y);
        for (int m = 1; m < 40; m += 2)
          u -= 8 / (kPi * kPi * kPi) * std::sin(m * kPi * y) * std::exp(-m * m * kPi * kPi * nu * t) / (m * m * m);
        return u;
      });
      worst = std::max(worst, e / 0.25);
      if (t > 1 - 1e-9) {
        report("channel start-up, viscous number nu dt/h2 = %.0f: error %.1e at most, %.1e at the end\n",
               nu * dt * n * n, worst, e / 0.25);
        EXPECT_LT(e / 0.25, 2e-3);
      }
    }
    EXPECT_LT(worst, dt > 0.05 ? 0.15 : 0.01);
  }
}

TEST(StretchedGrid, VortexInFlatCells) {
  // psi = sin(2 pi x/L) sin(2 pi y/H) decays without changing its shape, also in cells of aspect 20 or graded ones.
  auto error = [](int n, double H, double ratio) {
    FluidSettings s;
    s.density = 1, s.viscosity = 0.002, s.convection = Convection::kCentral, s.pressure_rtol = 1e-8;
    s.implicit_viscosity = Choice::kOn;
    const double kx = 2 * kPi, ky = 2 * kPi / H, rate = s.viscosity * (kx * kx + ky * ky), T = 0.25 / rate;
    const int steps = 6 * n;
    s.dt = T / steps;
    const double r = std::pow(ratio, 16.0 / n);
    CfdBox box({graded_nodes(0, 1, n, r, true), graded_nodes(0, H, n, r, true), uniform(0, 1.0 / n, 1)},
               {true, true, true}, s);
    const double amplitude = 0.3 * H / T;
    auto u = [&](double t) -> Function {
      return [=](double x, double y, double) {
        return amplitude * std::sin(kx * x) * std::cos(ky * y) * std::exp(-rate * t);
      };
    };
    auto v = [&](double t) -> Function {
      return [=](double x, double y, double) {
        return -amplitude * kx / ky * std::cos(kx * x) * std::sin(ky * y) * std::exp(-rate * t);
      };
    };
    auto now = box.face_field(), old = box.face_field();
    box.set_faces(0, now[0], u(0)), box.set_faces(1, now[1], v(0));
    box.set_faces(0, old[0], u(-s.dt)), box.set_faces(1, old[1], v(-s.dt));
    CellField<FineGrid> p(box.eps_begin.box());
    box.set(p, [&](double x, double y, double) {
      return 0.25 * amplitude * amplitude * (std::cos(2 * kx * x) + kx * kx / (ky * ky) * std::cos(2 * ky * y));
    });
    box.fluid->set_state(0, now, p, box.eps_begin, s.dt, old, box.eps_begin);
    for (int k = 0; k < steps; ++k) box.step(s.dt);
    return box.face_error(0, u(T)) / amplitude;
  };
  const double set[5][2] = {{1, 1.1}, {1, 1.2}, {1, 1.3}, {0.05, 1.0}, {0.05, 1.2}};
  for (const auto& x : set) {
    const double e1 = error(24, x[0], x[1]), e2 = error(48, x[0], x[1]);
    report("vortex, box 1 x %g, stretch %g: error %.2e %.2e, order %.2f\n", x[0], x[1], e1, e2, std::log2(e1 / e2));
    EXPECT_GT(std::log2(e1 / e2), 1.9);
  }
}
