// Flow with inertia around bodies: drag against published figures; starts from rest, at high Courant numbers.
#include <gtest/gtest.h>

#include <algorithm>

#include "cfd/bodies/wall_stress.h"
#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

/// Channel of 2.2 m x 0.41 m with a cylinder of 0.1 m at (0.2, 0.2) (Schaefer & Turek 1996), parabolic inflow of the mean
/// velocity U, viscosity 1e-3 m2/s. plane: the two directions.
struct Channel {
  FluidSettings s;
  std::array<std::vector<double>, 3> nodes;
  int x, y, z;
  static constexpr double D = 0.1;
  double U;

  Channel(int x_, int z_, int across, double U_, Convection scheme) : x(x_), y(3 - x_ - z_), z(z_), U(U_) {
    s.density = 1, s.viscosity = 1e-3;
    s.convection = scheme;
    s.cfl = 0.6;
    s.pressure_rtol = 1e-5;
    for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
    s.side[2 * y] = s.side[2 * y + 1] = {condition(BoundaryKind::kNoSlip)};
    Vec3 in{0, 0, 0};
    in[x] = U;
    s.side[2 * x] = {condition(BoundaryKind::kInlet, in)};
    s.side[2 * x][0].profile.shape = InletProfile::Shape::kParabolic;
    s.side[2 * x][0].profile.across[y] = true;
    s.side[2 * x + 1] = {condition(BoundaryKind::kPressure)};
    Vec3 centre{0, 0, 0}, axis{0, 0, 0};
    centre[x] = centre[y] = 0.2, axis[z] = 1;
    s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, 0.05, FluidIs::kOutside))};
    const double h = 0.41 / across;
    nodes[x] = uniform(0, 2.2, int(std::lround(2.2 / h))), nodes[y] = uniform(0, 0.41, across);
    nodes[z] = uniform(0, h, 1);
  }
};

/// Pressure on the cylinder at (0.15, 0.2) or, downstream, (0.25, 0.2): by the parabola in y through the three places on its
/// surface that are nearest.
double pressure_at(const CfdBox& box, int x, int y, bool downstream) {
  const WallStress& w = *box.fluid->wall_stress();
  std::vector<std::array<double, 2>> at;
  for (std::size_t q = 0; q < w.facets().size(); ++q)
    if ((w.facets()[q].centre[x] > 0.2) == downstream) at.push_back({w.facets()[q].centre[y] - 0.2, w.pressure(q)});
  std::sort(at.begin(), at.end(), [](auto& a, auto& b) { return std::abs(a[0]) < std::abs(b[0]); });
  double p = 0;
  for (int a = 0; a < 3; ++a) {
    double part = at[a][1];
    for (int b = 0; b < 3; ++b)
      if (b != a) part *= at[b][0] / (at[b][0] - at[a][0]);
    p += part;
  }
  return p;
}

}  // namespace

// DFG benchmark 2D-1 at 10 cells across the cylinder: drag 5.57953523, lift 0.010618948 (FeatFlow's tables for Schaefer &
// Turek 1996).
// Drag, measured: central +0.96, 0.73, 0.38, 0.20, 0.10 % at 8, 10, 15, 20, 30 cells (order 1.8); in 25 places of grids of
// 9.5 to 10.5 cells +0.74 +- 0.05 % (van Leer +0.97 +- 0.10 %). That is the truncation of convection in the fluid, not the
// walls: interpolating convected velocities and fluxes to fourth order wherever four open faces stand in a row gave -0.03 %
// in this place; without inertia drag is 0.7 % too low.
// Pressure, front less rear, in 15 places: central -3.9 +- 0.9 %, van Leer -2.4 +- 0.9 %. Most of it is the fit's: at the
// front pressure steepens within a cell of the wall (dp/dn = mu d2u_n/dn2), which polynomials through cells don't see. Of a
// flow at 30 cells, sampled at these cells' centres, they give -2.2 %, of this flow -3.0 % (van Leer -1.3 %).
TEST(BodiesInFlow, CylinderInChannelAtRe20) {
  for (int turn : {0, 1}) {
    Channel c(turn, 2, 41, 0.2, turn == 0 ? Convection::kCentral : Convection::kVanLeer);
    c.s.pressure_rtol = 1e-8;  // at 1e-5 the pressure of a single step is off by some 1e-3 Pa
    c.s.wall_stress = true;
    CfdBox box(c.nodes, {false, false, false}, c.s);
    const double scale = 0.5 * c.U * c.U * c.D * box.grid.axis[c.z].length();
    for (int t = 0; t < 5; ++t) box.step(1.0);
    const BodyForce& F = box.fluid->body_forces()[0];
    const double drag = F.force()[c.x] / scale, lift = F.force()[c.y] / scale;
    report(
        "cylinder in a channel, Re 20, along %d: drag %.4f (%+.2f %%; friction %.4f, pressure %.4f, convection %.1e), "
        "lift "
        "%.4f\n",
        turn, drag, 100 * (drag / 5.57953523 - 1), F.friction[c.x] / scale, F.pressure[c.x] / scale,
        F.convection[c.x] / scale, lift);
    EXPECT_NEAR(drag / 5.57953523, 1, turn == 0 ? 0.008 : 0.011);  // 0.5 % is wanted
    EXPECT_NEAR(lift, 0.0106, 0.005);
    box.fluid->wall_stress()->take();
    const double front = pressure_at(box, c.x, c.y, false), rear = pressure_at(box, c.x, c.y, true);
    const auto sums = box.fluid->wall_stress()->sums()[0];
    report(
        "  pressure at its front less that at its rear %.5f Pa (%+.2f %%); facets: friction %.4f, pressure %.4f, drag "
        "%+.2f %%\n",
        front - rear, 100 * ((front - rear) / 0.11752017 - 1), sums[0][c.x] / scale, sums[1][c.x] / scale,
        100 * ((sums[0][c.x] + sums[1][c.x]) / scale / 5.57953523 - 1));
    EXPECT_NEAR((front - rear) / 0.11752017, 1, turn == 0 ? 0.035 : 0.018);  // 1 to 2 % is wanted
    EXPECT_NEAR((sums[0][c.x] + sums[1][c.x]) / F.force()[c.x], 1, 0.02);
  }
}

// Schaefer & Turek (1996), 2D-2: Strouhal number 0.295 to 0.305, largest drag 3.22 to 3.24, largest lift 0.99 to 1.01. Measured:
// 0.3009, 3.237, 0.917 (least -0.955); with convection interpolated to fourth order away from walls 0.3017, 3.256, 0.962
// (-1.001): lift is lost to convection's truncation, too. Some minutes: --gtest_also_run_disabled_tests.
TEST(BodiesInFlow, DISABLED_CylinderInChannelAtRe100) {
  Channel c(0, 2, 82, 1.0, Convection::kCentral);
  CfdBox box(c.nodes, {false, false, false}, c.s);
  const double scale = 0.5 * c.U * c.U * c.D * box.grid.axis[c.z].length(), dt = 0.005;
  double most_drag = 0, most_lift = 0, before = 0, first = 0, last = 0;
  int rises = 0;
  for (int n = 1; n * dt < 8; ++n) {
    box.step(dt);
    const BodyForce& F = box.fluid->body_forces()[0];
    const double drag = F.force()[c.x] / scale, lift = F.force()[c.y] / scale;
    if (n % 100 == 0) report("t %.2f drag %.4f lift %.4f\n", n * dt, drag, lift);
    if (n * dt > 6) {
      most_drag = std::max(most_drag, drag), most_lift = std::max(most_lift, lift);
      if (before < 0 && lift >= 0) {
        last = (n - lift / (lift - before)) * dt;
        if (rises++ == 0) first = last;
      }
    }
    before = lift;
  }
  const double strouhal = (rises - 1) / (last - first) * c.D / c.U;
  report("cylinder in a channel, Re 100: Strouhal %.4f, largest drag %.4f, largest lift %.4f\n", strouhal, most_drag,
         most_lift);
  EXPECT_GT(strouhal, 0.295);
  EXPECT_LT(strouhal, 0.305);
}

// Without bounds, Re 20 and 40: drag 2.009 and 1.501 (polar solution with its far field at 100 diameters; published 2.00 to
// 2.09, 1.50 to 1.58).
TEST(BodiesInFlow, DISABLED_CylinderAlone) {
  for (int Re : {20, 40}) {
    const double h = 1.0 / 16;
    std::array<std::vector<double>, 3> nodes;
    const auto axis = [h](double fine_lo, double fine_hi, double lo, double hi) {
      std::vector<double> x;
      for (double a = fine_lo; a < fine_hi + 0.5 * h; a += h) x.push_back(a);
      for (double w = 1.1 * h; x.back() < hi; w *= 1.1) x.push_back(x.back() + w);
      for (double w = 1.1 * h; x.front() > lo; w *= 1.1) x.insert(x.begin(), x.front() - w);
      return x;
    };
    nodes[0] = axis(-1.5, 4, -60, 60), nodes[1] = axis(-1.5, 1.5, -60, 60), nodes[2] = {0, h};
    FluidSettings s;
    s.density = 1, s.viscosity = 1.0 / Re;
    s.convection = Convection::kCentral, s.cfl = 0.6;
    s.pressure_rtol = 1e-5;
    for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
    s.side[0] = {condition(BoundaryKind::kInlet, {1, 0, 0})}, s.side[1] = {condition(BoundaryKind::kPressure)};
    s.initial_velocity = {1, 0, 0};
    s.bodies = {body(std::make_shared<CylinderShape>(Vec3{0.013, 0.017, 0}, Vec3{0, 0, 1}, 0.5, FluidIs::kOutside))};
    CfdBox box(nodes, {false, false, false}, s);
    double drag = 0;
    for (int t = 0; t < 60; t += 5) {
      box.step(5);
      drag = box.fluid->body_forces()[0].force()[0] / (0.5 * h);
      report("Re %d, t %d: drag %.4f\n", Re, t + 5, drag);
    }
    EXPECT_NEAR(drag / (Re == 20 ? 2.009 : 1.501), 1, 0.02);
  }
}

namespace {

/// Largest speed of own solved faces, and of slivers among them (m/s).
void fastest(const CfdBox& box, double& all, double& slivers) {
  all = slivers = 0;
  for (int d = 0; d < 3; ++d)
    for_each(box.faces(d), [&](int i, int j, int k) {
      const double u = std::abs(box.fluid->velocity()[d](i, j, k));
      all = std::max(all, u);
      if (box.fluid->open_shares()->sliver(d, box.fluid->velocity()[d].index(i, j, k))) slivers = std::max(slivers, u);
    });
  all = box.largest(all), slivers = box.largest(slivers);
}

/// Goes on for some intervals; U: of the inlet; wave > 0: eps moves through the bodies at that rate (1/s).
void run(const char* name, CfdBox& box, double interval, int intervals, double U, double wave = 0) {
  double most = 0, slivers = 0, all, of_slivers, continuity = 0;
  int steps = 0;
  for (int n = 0; n < intervals; ++n) {
    if (wave > 0)
      box.set(box.eps_end, [&](double x, double y, double z) {
        return 0.7 + 0.25 * std::sin(9 * x + 5 * y + 7 * z - wave * (n + 1) * interval);
      });
    const FluidReport r = box.step(interval);
    box.eps_begin = box.eps_end;
    steps += r.steps;
    fastest(box, all, of_slivers);
    most = std::max(most, all), slivers = std::max(slivers, of_slivers);
    continuity = std::max(continuity, r.divergence_error);
  }
  report("%s: fastest %.2f U (slivers %.2f), at the end %.2f U; %d steps, continuity %.1e\n", name, most / U,
         slivers / U, all / U, steps, continuity);
  EXPECT_LT(most, (wave > 0 ? 5 : 2.5) * U);
  EXPECT_LT(continuity, 1e-3);
  EXPECT_LT(steps, 60 * intervals);
}

FluidSettings fast_gas(double cfl, double Re) {
  FluidSettings s;
  s.density = 1, s.viscosity = 1 / Re;
  s.cfl = cfl;
  s.pressure_rtol = 1e-5;
  for (auto& side : s.side) side = {condition(BoundaryKind::kNoSlip)};
  return s;
}

/// Starts at once, at high Courant numbers; eps moves through the last body.
void start_at_once(double Re, const std::vector<double>& limits) {
  for (double cfl : limits) {
    const std::array<std::vector<double>, 3> nodes{uniform(0, 1, 16), uniform(0, 1, 16), uniform(0, 2, 32)};
    const std::array<bool, 3> periodic{false, false, false};
    FluidSettings s = fast_gas(cfl, Re);
    s.side[5] = {condition(BoundaryKind::kPressure)};
    BoundaryCondition nozzle = condition(BoundaryKind::kInlet, {0, 0, 1});
    nozzle.shape.kind = PatchShape::Kind::kCircle;
    nozzle.shape.value = {0.2, 0.5, 0.1, 0};
    s.side[4].push_back(nozzle);
    s.bodies = {body(std::make_shared<CylinderShape>(Vec3{0.523, 0.511, 0}, Vec3{0.1, 0, 1}, 0.41, FluidIs::kInside))};
    CfdBox jet(nodes, periodic, s);
    run("jet along a wall", jet, 0.1, 40, 1);
    s.side[4] = {condition(BoundaryKind::kInlet, {0, 0, 1})};
    s.bodies = {body(std::make_shared<CylinderShape>(Vec3{0.523, 0.511, 0}, Vec3{0, 0, 1}, 0.41, FluidIs::kInside))};
    CfdBox pipe(nodes, periodic, s);
    run("pipe", pipe, 0.1, 20, 1);
    s.bodies = {body(std::make_shared<SphereShape>(Vec3{0.523, 0.511, 0.6}, 0.22, FluidIs::kOutside))};
    CfdBox ball(nodes, periodic, s);
    run("ball", ball, 0.1, 30, 1);
    CfdBox box(nodes, periodic, s);
    box.set(box.eps_begin, [&](double x, double y, double z) { return 0.7 + 0.25 * std::sin(9 * x + 5 * y + 7 * z); });
    box.fluid->start(box.eps_begin);
    run("ball, eps moving", box, 0.02, 60, 1, 10);
  }
}

}  // namespace

TEST(BodiesInFlow, StartsAtHighCourantNumbers) {
  start_at_once(1e3, {0.9});
}

// Gas so thin that friction at the walls is nothing.
TEST(BodiesInFlow, StartsOfThinGas) {
  start_at_once(1e5, {0.4, 0.9});
}
