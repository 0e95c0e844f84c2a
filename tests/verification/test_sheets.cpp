// Sheets in the fluid (cfd/bodies/sheets.h): flow on both sides of a draft tube, nothing through a sheet, momentum.
// Without these a sheet that leaks between its steps, one that rubs on one side only or twice, or a force that counts the
// pressure of one side would pass.
#include <gtest/gtest.h>

#include "cfd/bodies/triangle_set.h"
#include "cfd/bodies/wall_stress.h"
#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

Body sheet(std::vector<Triangle> triangles, const char* name = "sheet") {
  Body b = body(std::make_shared<TriangleSet>(std::move(triangles)), name);
  b.sheet = true;
  return b;
}

std::vector<Triangle> quadrangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {{a, b, c}, {a, c, d}};
}

/// A round tube along an axis, of a circle's area.
std::vector<Triangle> tube(int along, const Vec3& centre, double radius, double from, double to) {
  constexpr int n = 120;
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  const double corner = radius * std::sqrt(2 * kPi / n / std::sin(2 * kPi / n));
  std::vector<Triangle> all;
  const auto at = [&](int i, double z) {
    Vec3 x = centre;
    x[e] += corner * std::cos(2 * kPi * i / n), x[f] += corner * std::sin(2 * kPi * i / n), x[along] = z;
    return x;
  };
  for (int i = 0; i < n; ++i)
    for (const Triangle& t : quadrangle(at(i, from), at(i + 1, from), at(i + 1, to), at(i, to))) all.push_back(t);
  return all;
}

/// A pressure gradient of -1 Pa/m along an axis, by outlets at both ends: the fluid's parts need not be joined.
void between_pressures(FluidSettings& s, int along, double length) {
  s.side[2 * along] = {condition(BoundaryKind::kPressure, {0, 0, 0}, length)};
  s.side[2 * along + 1] = {condition(BoundaryKind::kPressure)};
}

/// Error of the flow through a pipe of 0.42 m with a sheet of 0.21 m around its axis; N cells a metre.
double draft_tube(int along, int N, int salt) {
  const double R = 0.42, r = 0.21;
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  FluidSettings s = creeping(0.002);
  between_pressures(s, along, 4.0 / N);
  Vec3 centre{0, 0, 0}, axis{0, 0, 0};
  axis[along] = 1;
  centre[e] = 0.5 + (random_number(2 * salt) - 0.5) / N, centre[f] = 0.5 + (random_number(2 * salt + 1) - 0.5) / N;
  s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, R, FluidIs::kInside), "pipe"),
              sheet(tube(along, centre, r, -1, 2))};
  std::array<std::vector<double>, 3> nodes;
  nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 1, N), nodes[along] = uniform(0, 4.0 / N, 4);
  CfdBox box(nodes, {false, false, false}, s);
  EXPECT_GT(until_steady(box, along, s.dt, 1e-6, 400), 0);
  const double ring = (R * R - r * r) * (R * R - r * r) / std::log(R / r);
  const double error = superficial(box, along) / (kPi / 8 * (std::pow(R, 4) - ring)) - 1;
  double force = 0;
  for (const BodyForce& b : box.fluid->body_forces()) force += b.force()[along];
  const double balance = force / box.fluid->open_shares()->volume() - 1;
  report("draft tube along %d, %.1f cells across it and %.1f beside it, place %d: flow %+.2f %%, force %+.1e\n", along,
         2 * r * N, (R - r) * N, salt, 100 * error, balance);
  EXPECT_LT(std::abs(balance), 2e-4);  // the flow still gains a little when it counts as steady
  return error;
}

}  // namespace

TEST(Sheets, DraftTubeInAPipe) {
  double worst[2] = {0, 0};
  for (int salt = 0; salt < (ranks_of(MPI_COMM_WORLD) > 1 ? 1 : 4); ++salt) {
    worst[0] = std::max(worst[0], std::abs(draft_tube(salt % 3, 16, salt)));
    if (salt < 2) worst[1] = std::max(worst[1], std::abs(draft_tube(salt % 3, 32, salt)));
  }
  report("draft tube: at most %.2f and %.2f %%\n", 100 * worst[0], 100 * worst[1]);
  EXPECT_LT(worst[0], 0.025);
  EXPECT_LT(worst[1], 0.01);
}

/// In the middle of a channel, on faces and between them: two channels.
TEST(Sheets, InAChannel) {
  for (int along : {0, 1, 2})
    for (double place : {0.5, 0.53125}) {
      const int N = 16, e = (along + 1) % 3, f = (along + 2) % 3;
      FluidSettings s = creeping(0.002);
      between_pressures(s, along, 4.0 / N);
      s.side[2 * e] = s.side[2 * e + 1] = {condition(BoundaryKind::kNoSlip)};
      std::array<Vec3, 4> corner;
      for (int q = 0; q < 4; ++q) {
        corner[q][e] = place;
        corner[q][along] = q == 0 || q == 3 ? -1 : 2;
        corner[q][f] = q < 2 ? -1 : 2;
      }
      s.bodies = {sheet(quadrangle(corner[0], corner[1], corner[2], corner[3]))};
      s.wall_stress = true;
      std::array<std::vector<double>, 3> nodes;
      nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 4.0 / N, 4), nodes[along] = uniform(0, 4.0 / N, 4);
      CfdBox box(nodes, {false, false, false}, s);
      EXPECT_GT(until_steady(box, along, s.dt, 1e-6, 400), 0);
      const double exact = (std::pow(place, 3) + std::pow(1 - place, 3)) / 12,
                   error = superficial(box, along) / exact - 1;
      report("sheet at %.5f of a channel along %d: flow %+.2f %%\n", place, along, 100 * error);
      EXPECT_LT(std::abs(error), 0.02);  // at 8 cells a channel
      // Friction of each side, over half its channel's width times the gradient.
      const WallStress& w = *box.fluid->wall_stress();
      double apart = 0, above = 0, below = 0;
      for (std::size_t q = 0; q < w.facets().size(); ++q) {
        const bool high = w.facets()[q].normal[e] > 0;
        apart = std::max(apart, std::abs(w.friction(q)[along] / (0.5 * (high ? 1 - place : place)) - 1));
        (high ? above : below) += w.facets()[q].area;
      }
      apart = box.largest(apart), above = box.sum(above), below = box.sum(below);
      report("  friction on its two sides, at most %.2f %% off; areas %.4f, %.4f\n", 100 * apart, above, below);
      EXPECT_LT(apart, 0.09);  // a sheet is right to half a cell
      EXPECT_NEAR(above, 1.0 / 16, 1e-12);
      EXPECT_NEAR(below, 1.0 / 16, 1e-12);
    }
}

/// From side to side at an angle, with pressure on one side.
TEST(Sheets, NothingPasses) {
  for (int turn = 0; turn < 3; ++turn) {
    const auto turned = [&](double x, double y, double z) {
      Vec3 v;
      v[turn] = x, v[(turn + 1) % 3] = y, v[(turn + 2) % 3] = z;
      return v;
    };
    const int up = (turn + 2) % 3;
    FluidSettings s;
    s.density = 1.2, s.viscosity = 2e-3;
    s.dt = 2e-3;
    s.pressure_rtol = 1e-12;
    for (auto& side : s.side) side = {condition(BoundaryKind::kNoSlip)};
    s.side[2 * up] = {condition(BoundaryKind::kPressure, {0, 0, 0}, 5)};
    s.side[2 * up + 1] = {condition(BoundaryKind::kPressure)};
    s.bodies = {sheet(quadrangle(turned(-1, -1, -0.1), turned(2, -1, 1.1), turned(2, 2, 1.4), turned(-1, 2, 0.2)))};
    CfdBox box({uniform(0, 1, 12), uniform(0, 1, 12), uniform(0, 1, 12)}, {false, false, false}, s);
    for (int n = 0; n < 10; ++n) box.step(2e-3);
    double passed = 0;
    for_each(box.faces(up), [&](int i, int j, int k) {
      passed = std::max(passed, std::abs(box.fluid->flux(up, i, j, k)) * box.grid.area(up, i, j, k));
    });
    const Vec3 force = box.fluid->body_forces()[0].force();
    report("sheet from side to side: passes %.1e m3/s, force %.6f N of 5 along, %.4f and %.4f across\n",
           box.largest(passed), force[up], force[turn], force[(turn + 1) % 3]);
    EXPECT_LT(box.largest(passed), 1e-12);
    EXPECT_NEAR(force[up], 5, 1e-9);
    // The slopes of the sheet, to half a cell of its rise.
    EXPECT_NEAR(force[turn], -5 * 0.4, 5 * 0.5 / 12);
    EXPECT_NEAR(force[(turn + 1) % 3], -5 * 0.1, 5 * 0.5 / 12);
  }
}

/// A baffle in a gas that moves: what it takes, the gas has lost.
TEST(Sheets, Momentum) {
  FluidSettings s;
  s.density = 1.2, s.viscosity = 2e-3;
  s.pressure_rtol = 1e-12;
  s.dt = 2e-3;
  s.pressure_gradient = {-3, 0.5, -1};
  s.bodies = {sheet(quadrangle({0.2, 0.3, 0.2}, {0.8, 0.25, 0.3}, {0.75, 0.7, 0.8}, {0.25, 0.72, 0.66}))};
  CfdBox box({uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)}, {true, true, true}, s);
  // The mean gradient drives all of the box, what lies beside closed faces, too.
  Vec3 driven{0, 0, 0}, before{0, 0, 0};
  for (int d = 0; d < 3; ++d) driven[d] = -s.pressure_gradient[d];
  double worst = 0, given = 0;
  for (int step = 0; step < 30; ++step) {
    box.step(s.dt);
    const Vec3 total = box.fluid->total_momentum(), pending = box.fluid->pending_momentum(),
               force = box.fluid->body_forces()[0].force();
    for (int d = 0; d < 3; ++d) {
      const double now = total[d] + pending[d];
      if (step > 0) worst = std::max(worst, std::abs((now - before[d]) / s.dt - driven[d] + force[d]));
      before[d] = now, given = std::max(given, std::abs(force[d]));
    }
  }
  report("baffle: takes up to %.3f N, missing %.1e N\n", given, worst);
  EXPECT_GT(given, 0.01);
  EXPECT_LT(worst, 1e-12);
}
