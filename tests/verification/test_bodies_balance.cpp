// What the bodies in a fluid's grid take and give: total momentum of fluid, bodies and sides, gas at rest, continuity of
// every cell, and the same numbers whichever way the axes lie. Without these, a force that misses a part, a wall that
// pumps, area that leaks or an axis taken for another would pass.
#include <gtest/gtest.h>

#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

/// A periodic box: the fluid's momentum changes by what drives it less what the bodies take, while eps moves in cut
/// cells and exchange with particles goes on. The mean gradient drives all that is open, beside closed faces, too; given, or
/// found to hold a flow rate.
TEST(BodiesBalance, MomentumOfAPeriodicBox) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral, Convection::kNone})
    for (Choice implicit : {Choice::kOff, Choice::kOn}) {
      FluidSettings s = tube_and_ball(scheme, implicit);
      for (auto& side : s.side) side.clear();
      const bool held = scheme == Convection::kCentral;
      if (held)
        s.flow_rate_set = {true, true, true}, s.flow_rate = {0.3, -0.1, 0.2};
      else
        s.pressure_gradient = {-3, 0.5, -1};
      CfdBox box({uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)}, {true, true, true}, s);
      box.fluid->keep_pressure_gradient();
      const auto eps = [&](double t) {
        return [t](double x, double y, double z) {
          return 0.7 + 0.2 * std::sin(2 * kPi * (x + y - 3 * t)) * std::cos(2 * kPi * z);
        };
      };
      box.set(box.eps_begin, eps(0));
      box.fluid->start(box.eps_begin);
      Interphase exchange;
      for (int c = 0; c < 3; ++c) exchange.source[c].reset(box.faces(c), 0.4 * (c - 0.7));
      double worst = 0, pushed = 0, given = 0;
      const double volume = open_volume(box);
      Vec3 by_particles{0, 0, 0};
      for (int d = 0; d < 3; ++d) {
        double sum = 0;
        for_each(box.faces(d), [&](int i, int j, int k) {
          if (box.fluid->face_state(d)(i, j, k) == FaceState::kSolved)
            sum += exchange.source[d](i, j, k) * box.fluid->measures().volume(d, i, j, k);
        });
        by_particles[d] = box.sum(sum);
      }
      Vec3 before{0, 0, 0};
      for (int step = 0; step < 12; ++step) {
        box.set(box.eps_end, eps(s.dt * (step + 1)));
        box.step(s.dt, exchange);
        box.eps_begin = box.eps_end;
        const Vec3 total = box.fluid->total_momentum(), pending = box.fluid->pending_momentum();
        for (int d = 0; d < 3; ++d) {
          // The mean of grad p along the box's edge, where no body is.
          double gradient = 0;
          for_each(box.faces(d), [&](int i, int j, int k) {
            const Int3 x{i, j, k};
            if (x[(d + 1) % 3] == 0 && x[(d + 2) % 3] == 0)
              gradient += box.fluid->mean_pressure_gradient()[d](i, j, k) / box.grid.axis[d].n();
          });
          gradient = box.sum(gradient);
          if (!held) {
            EXPECT_NEAR(gradient, s.pressure_gradient[d], 1e-10);
          }
          double taken = 0;
          for (const BodyForce& b : box.fluid->body_forces()) taken += b.force()[d];
          const double now = total[d] + pending[d], driven = by_particles[d] - gradient * volume;
          if (step > 0) {
            worst = std::max(worst, std::abs((now - before[d]) / s.dt - driven + taken));
            pushed = std::max(pushed, std::abs(driven)), given = std::max(given, std::abs(taken));
          }
          before[d] = now;
        }
      }
      report("momentum, convection %d, implicit %d: driven %.3f N, bodies %.3f N, missing %.1e N\n", int(scheme),
             int(implicit), pushed, given, worst);
      EXPECT_GT(given, (held ? 0.02 : 0.1) * pushed);
      EXPECT_LT(worst, (implicit == Choice::kOn ? 1e-8 : 1e-12) * pushed);
    }
}

/// Hydrostatic pressure, and the same pressure everywhere, around bodies that cut cells.
TEST(BodiesBalance, GasAtRestStaysAtRest) {
  for (int d : {0, 1, 2}) {
    FluidSettings s = tube_and_ball(Convection::kVanLeer, Choice::kAuto);
    s.side[5] = {condition(BoundaryKind::kPressure, {0, 0, 0}, 3)};
    CfdBox box({uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)}, {false, false, false}, s);
    auto zero = box.face_field();
    CellField<FineGrid> p(box.eps_begin.box());
    const double f = d == 2 ? 0 : 12;  // across the outlet's plane none
    box.set(p, [&](double x, double y, double z) { return 3 + f * (d == 0 ? x : d == 1 ? y : z); });
    box.set(box.eps_begin,
            [](double x, double y, double z) { return 0.6 + 0.3 * std::sin(5 * x + 3 * y) * std::cos(4 * z); });
    box.eps_end = box.eps_begin;
    if (f != 0) s.side[5] = {condition(BoundaryKind::kSlip)};
    CfdBox closed({uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)}, {false, false, false}, s);
    CfdBox& b = f != 0 ? closed : box;
    closed.eps_begin = closed.eps_end = box.eps_begin;
    b.fluid->set_state(0, zero, p, b.eps_begin, 0, zero, b.eps_begin);
    Interphase exchange;
    if (f != 0) {
      for (int c = 0; c < 3; ++c) exchange.source[c].reset(b.faces(c));
      for_each(b.faces(d), [&](int i, int j, int k) {
        exchange.source[d](i, j, k) = f * b.fluid->open_shares()->theta_f()[d](i, j, k);
      });
    }
    for (int step = 0; step < 10; ++step) b.step(2e-3, exchange);
    double fastest = 0;
    for (int c = 0; c < 3; ++c)
      for_each(b.faces(c),
               [&](int i, int j, int k) { fastest = std::max(fastest, std::abs(b.fluid->velocity()[c](i, j, k))); });
    fastest = b.largest(fastest);
    report("at rest, %d: %.1e m/s\n", d, fastest);
    EXPECT_LT(fastest, 1e-12);
  }
}

/// The same flow with its axes turned round and mirrored: the same forces, and continuity of every cell.
TEST(BodiesBalance, TheSameWhicheverWayTheAxesLie) {
  const Vec3 length{1, 0.9, 1.6};
  const Int3 cells{12, 11, 18};
  std::vector<Vec3> forces, torques;
  for (int turn = 0; turn < 3; ++turn)
    for (int mirror : {0, 1, 5, 7}) {
      const auto at = [&](int d) { return (d + turn) % 3; };
      const auto high = [&](int d) { return mirror >> d & 1; };
      const auto turned = [&](const Vec3& x) {
        Vec3 y;
        for (int d = 0; d < 3; ++d) y[at(d)] = high(d) ? length[d] - x[d] : x[d];
        return y;
      };
      const auto direction_of = [&](const Vec3& v) {
        Vec3 w;
        for (int d = 0; d < 3; ++d) w[at(d)] = high(d) ? -v[d] : v[d];
        return w;
      };
      FluidSettings s;
      s.density = 1.2, s.viscosity = 3e-3;
      s.pressure_rtol = 1e-11;
      s.dt = 0.01;
      for (auto& side : s.side) side = {condition(BoundaryKind::kNoSlip)};
      s.side[2 * at(2) + high(2)] = {condition(BoundaryKind::kInlet, direction_of({0.2, 0, 1}))};
      s.side[2 * at(2) + !high(2)] = {condition(BoundaryKind::kPressure)};
      s.bodies = {body(std::make_shared<CylinderShape>(turned({0.51, 0.43, 0}), direction_of({0.2, 0, 1}), 0.38,
                                                       FluidIs::kInside)),
                  body(std::make_shared<SphereShape>(turned({0.6, 0.5, 0.7}), 0.17, FluidIs::kOutside))};
      std::array<std::vector<double>, 3> nodes;
      for (int d = 0; d < 3; ++d) nodes[at(d)] = uniform(0, length[d], cells[d]);
      CfdBox box(nodes, {false, false, false}, s);
      double worst = 0;
      for (int step = 0; step < 10; ++step) {
        box.step(0.01);
        for_each(box.own(), [&](int i, int j, int k) {
          double sum = box.fluid->void_fraction_rate(i, j, k) * box.grid.volume(i, j, k);
          for (int d = 0; d < 3; ++d) {
            Int3 next{i, j, k};
            ++next[d];
            sum += box.grid.area(d, i, j, k) *
                   (box.fluid->flux(d, next[0], next[1], next[2]) - box.fluid->flux(d, i, j, k));
          }
          worst = std::max(worst, std::abs(sum) / std::pow(box.grid.volume(i, j, k), 2.0 / 3));
        });
      }
      worst = box.largest(worst);
      EXPECT_LT(worst, 1e-9);
      for (const BodyForce& b : box.fluid->body_forces()) {
        Vec3 force, torque;
        const bool odd = (mirror & 1) ^ (mirror >> 1 & 1) ^ (mirror >> 2 & 1);  // a torque is no vector
        for (int d = 0; d < 3; ++d) {
          force[d] = (high(d) ? -1 : 1) * b.force()[at(d)];
          torque[d] = (high(d) ? -1 : 1) * (odd ? -1 : 1) * b.torque[at(d)];
        }
        forces.push_back(force), torques.push_back(torque);
      }
    }
  double apart = 0, twist = 0;
  for (std::size_t q = 2; q < forces.size(); ++q)
    for (int d = 0; d < 3; ++d) {
      apart = std::max(apart, std::abs(forces[q][d] - forces[q % 2][d]));
      twist = std::max(twist, std::abs(torques[q][d] - torques[q % 2][d]));
    }
  report(
      "turned and mirrored: force on the vessel %.4f %.4f %.4f N, on the ball %.4f %.4f %.4f N; apart %.1e N, torques "
      "%.1e N m\n",
      forces[0][0], forces[0][1], forces[0][2], forces[1][0], forces[1][1], forces[1][2], apart, twist);
  EXPECT_LT(apart, 1e-8);
  EXPECT_LT(twist, 1e-8);
}
