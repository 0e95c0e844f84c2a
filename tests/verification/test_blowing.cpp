// Bodies that blow gas into the fluid. Without these, gas that comes in without its momentum, or with it twice, walls that
// hold back what they blow, a flow that hangs on where the wall cuts the grid, or volume that is lost would pass.
#include <gtest/gtest.h>

#include "cfd/bodies/wall_stress.h"
#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

void blow(Body& body, double U) {
  body.blow.on = true;
  body.blow.velocity = U;
}

/// The sides' faces get a patch each, which prescribes what `at` says; one of them lets the rest out.
void prescribe(FluidSettings& s, const std::array<std::vector<double>, 3>& nodes, const std::array<bool, 3>& of_sides,
               const std::function<Vec3(const Vec3&)>& at, const SolidShape* shape = nullptr) {
  const int outlet = of_sides[0] ? kXhi : kYhi;
  for (int side = 0; side < 6; ++side) {
    const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
    s.side[side] = {condition(BoundaryKind::kSlip)};
    if (!of_sides[d]) continue;
    for (std::size_t j = 0; j + 1 < nodes[f].size(); ++j)
      for (std::size_t i = 0; i + 1 < nodes[e].size(); ++i) {
        Vec3 x;
        x[d] = is_high(side) ? nodes[d].back() : nodes[d].front();
        x[e] = 0.5 * (nodes[e][i] + nodes[e][i + 1]), x[f] = 0.5 * (nodes[f][j] + nodes[f][j + 1]);
        bool open = !shape;
        for (int q = 0; shape && q < 4; ++q) {
          Vec3 corner = x;
          corner[e] = nodes[e][i + (q & 1)], corner[f] = nodes[f][j + (q >> 1)];
          for (int c = 0; c < 3; ++c) corner[c] += 0.04 * (x[c] - corner[c]);  // less is closed
          open = open || shape->side(corner) == SolidShape::Side::kFluid;
        }
        if (!open) continue;
        const bool out = side == outlet && i == nodes[e].size() / 3 && j == nodes[f].size() / 3;
        BoundaryCondition c = condition(out ? BoundaryKind::kPressure : BoundaryKind::kInlet, at(x));
        c.name = std::to_string(i) + "_" + std::to_string(j);
        c.shape.kind = PatchShape::Kind::kRectangle;
        c.shape.value = {nodes[e][i], nodes[e][i + 1], nodes[f][j], nodes[f][j + 1]};
        s.side[side].push_back(c);
      }
  }
}

double largest_imbalance(const CfdBox& box) {
  double worst = 0;
  for_each(box.own(), [&](int i, int j, int k) {
    double sum = box.fluid->void_fraction_rate(i, j, k) * box.grid.volume(i, j, k);
    for (int d = 0; d < 3; ++d) {
      Int3 next{i, j, k};
      ++next[d];
      sum += box.grid.area(d, i, j, k) * (box.fluid->flux(d, next[0], next[1], next[2]) - box.fluid->flux(d, i, j, k));
    }
    worst = std::max(worst, std::abs(sum) / std::pow(box.grid.volume(i, j, k), 2.0 / 3));
  });
  return box.largest(worst);
}

/// The open part's centre of a face, by points on it.
Vec3 open_centre(const CfdBox& box, const SolidShape& shape, int d, const Int3& face) {
  constexpr int kPoints = 24;
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  Vec3 x = box.face(d, face[0], face[1], face[2]), sum{0, 0, 0};
  const Vec3 middle = x;
  const double we = box.grid.axis[e].width(face[e]), wf = box.grid.axis[f].width(face[f]);
  int open = 0;
  for (int i = 0; i < kPoints; ++i)
    for (int j = 0; j < kPoints; ++j) {
      x[e] = middle[e] + ((i + 0.5) / kPoints - 0.5) * we, x[f] = middle[f] + ((j + 0.5) / kPoints - 0.5) * wf;
      if (shape.side(x) == SolidShape::Side::kSolid) continue;
      for (int q = 0; q < 3; ++q) sum[q] += x[q];
      ++open;
    }
  for (int q = 0; q < 3 && open > 0; ++q) sum[q] /= open;
  return open > 0 ? sum : middle;
}

/// A source: u = U (R/r)^m, m 1 of a cylinder and 2 of a sphere, p + rho u^2/2 uniform.
struct Source {
  double velocity, pressure;  // largest errors, over U and rho U^2
  double rms_velocity, rms_pressure, mass, area;
  Vec3 force;
  double friction;  // largest on a facet, over mu U/R
};
Source source(int along, int N, Convection scheme, double viscosity, int salt) {
  const bool sphere = along < 0;
  const double R = 0.2, U = 1.3, rho = 1.1;
  FluidSettings s;
  s.density = rho, s.viscosity = viscosity;
  s.convection = scheme;
  s.pressure_rtol = 1e-9;
  s.wall_stress = true;
  s.cfl = 0.5;
  Vec3 centre, axis{0, 0, 0};
  for (int d = 0; d < 3; ++d) centre[d] = 0.5 + (random_number(3 * salt + d) - 0.5) / N;
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> of_sides{true, true, true};
  for (int d = 0; d < 3; ++d) nodes[d] = d == along ? uniform(0, 1.0 / N, 1) : uniform(0, 1, N);
  if (sphere) {
    s.bodies = {body(std::make_shared<SphereShape>(centre, R, FluidIs::kOutside))};
  } else {
    axis[along] = 1, centre[along] = 0, of_sides[along] = false;
    s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, R, FluidIs::kOutside))};
  }
  blow(s.bodies[0], U);
  const double whole = sphere ? 4 * kPi * R * R : 2 * kPi * R / N;
  double share = 1;  // of the surface as resolved
  const auto radius = [&](const Vec3& x, Vec3& way) {
    double r2 = 0;
    for (int d = 0; d < 3; ++d) way[d] = d == along ? 0 : x[d] - centre[d], r2 += way[d] * way[d];
    return std::sqrt(r2);
  };
  const auto exact = [&](const Vec3& x) {
    Vec3 u;
    const double r = radius(x, u), speed = share * U * (sphere ? R * R / (r * r) : R / r);
    for (double& c : u) c *= speed / r;
    return u;
  };
  Source out;
  for (bool known : {false, true}) {
    prescribe(s, nodes, of_sides, exact);
    CfdBox box(nodes, {false, false, false}, s);
    share = box.fluid->blowing()->area()[0] / whole;
    if (!known) continue;
    FluidReport r;
    for (int n = 0; n < 8; ++n) r = box.step(0.05);
    const OpenShares& open = *box.fluid->open_shares();
    double worst[2] = {0, 0}, sums[6] = {0, 0, 0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      if (d == along) continue;
      for_each(box.faces(d), [&](int i, int j, int k) {
        if (box.fluid->face_state(d)(i, j, k) != FaceState::kSolved) return;
        const std::ptrdiff_t m = open.theta().index(i, j, k);
        const Vec3 x = open.alpha(d, m) < 1 ? open_centre(box, *s.bodies[0].shape, d, {i, j, k}) : box.face(d, i, j, k);
        const double e = (box.fluid->velocity()[d](i, j, k) - exact(x)[d]) / U,
                     V = box.fluid->measures().open_volume(d, i, j, k);
        Vec3 way;
        if (!open.sliver(d, m) && radius(x, way) < 0.4) worst[0] = std::max(worst[0], std::abs(e));
        sums[0] += e * e * V, sums[1] += V;
      });
    }
    double offset[2] = {0, 0};
    const auto head = [&](int i, int j, int k, double& V) {
      Vec3 way;
      const double r = radius(box.cell(i, j, k), way), u = share * U * (sphere ? R * R / (r * r) : R / r);
      V = box.grid.volume(i, j, k) * (open.theta()(i, j, k) > 0.5);
      return box.fluid->pressure()(i, j, k) + (scheme == Convection::kNone ? 0 : 0.5 * rho * u * u);
    };
    for_each(box.own(), [&](int i, int j, int k) {
      double V;
      const double p = head(i, j, k, V);
      offset[0] += V * p, offset[1] += V;
    });
    const double mean = box.sum(offset[0]) / box.sum(offset[1]);
    for_each(box.own(), [&](int i, int j, int k) {
      double V;
      const double e = (head(i, j, k, V) - mean) / (rho * U * U);
      if (V > 0) worst[1] = std::max(worst[1], std::abs(e));
      sums[2] += e * e * V, sums[3] += V;
    });
    const double flow = U * box.fluid->blowing()->area()[0];
    out = {box.largest(worst[0]),
           box.largest(worst[1]),
           std::sqrt(box.sum(sums[0]) / box.sum(sums[1])),
           std::sqrt(box.sum(sums[2]) / box.sum(sums[3])),
           std::max(std::abs(r.outflow - r.inflow) / flow, largest_imbalance(box) / U),
           share,
           box.fluid->body_forces()[0].force(),
           0};
    for (std::size_t q = 0; q < box.fluid->wall_stress()->facets().size(); ++q) {
      const Vec3 t = box.fluid->wall_stress()->friction(q);
      out.friction = std::max(out.friction, std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) * R / (viscosity * U));
    }
    out.friction = box.largest(out.friction);
    EXPECT_NEAR(box.fluid->body_forces()[0].blown, flow, 1e-12 * flow);
    for (int d = 0; d < 3; ++d) out.force[d] /= rho * U * U * whole;
  }
  return out;
}

}  // namespace

/// Shifted on the grid at random, along each axis.
TEST(Blowing, SourceFlow) {
  struct Case {
    Convection scheme;
    double viscosity, velocity, most, pressure;
  };
  for (const Case& c :
       {Case{Convection::kVanLeer, 0.02, 0.011, 0.04, 0.009}, Case{Convection::kCentral, 0.02, 0.012, 0.04, 0.009},
        Case{Convection::kVanLeer, 0.0005, 0.034, 0.15, 0.009}, Case{Convection::kNone, 0.02, 0.0015, 0.007, 0.001}})
    for (int along : {2, 0, 1, -1}) {
      double before = 0;
      for (int fine = 0; fine < (along < 0 ? 1 : 2); ++fine) {
        const int N = (along < 0 ? 22 : 26) << fine;
        const Source q = source(along, N, c.scheme, c.viscosity, along + 7 * fine + 2);
        const double force = std::max({std::abs(q.force[0]), std::abs(q.force[1]), std::abs(q.force[2])});
        report(
            "source along %d, convection %d, viscosity %g, %d cells: velocity off by %.4f, %.4f where most, pressure "
            "%.4f, %.4f; "
            "surface %.4f; force %.1e, friction %.2f; volume %.1e\n",
            along, int(c.scheme), c.viscosity, N, q.rms_velocity, q.velocity, q.rms_pressure, q.pressure, q.area, force,
            q.friction, q.mass);
        const double less = fine ? 0.62 : along < 0 ? 1.5 : 1;
        EXPECT_LT(q.rms_velocity, less * c.velocity);
        EXPECT_LT(q.velocity, (along < 0 ? 2 : less) * c.most);
        EXPECT_LT(q.rms_pressure, less * c.pressure);
        EXPECT_LT(force, 0.006);
        EXPECT_NEAR(q.area, 1, along < 0 ? 0.015 : 0.002);
        EXPECT_LT(q.friction, c.scheme == Convection::kNone ? 0.2 : 4);
        EXPECT_LT(q.mass, 1e-6);
        EXPECT_LT(q.rms_velocity, fine && c.viscosity > 0.01 ? 0.45 * before : 1);
        before = q.rms_velocity;
      }
    }
}

/// From a plane at any angle to the grid gas comes as one uniform flow, and nothing resists it.
TEST(Blowing, UniformFlowFromAPlane) {
  for (bool implicit : {false, true})
    for (bool slip : {false, true})
      for (const Vec3& way : {Vec3{0.3, 0.8, 0.4}, Vec3{-0.5, 0.6, 0.1}, Vec3{0, 1, 0}}) {
        const double size = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]), U = 0.7;
        const Vec3 u{U * way[0] / size, U * way[1] / size, U * way[2] / size};
        FluidSettings s;
        s.density = 1.2, s.viscosity = 3e-3;
        s.implicit_viscosity = implicit ? Choice::kOn : Choice::kOff;
        s.pressure_rtol = 1e-12;
        s.dt = 0.01;
        s.bodies = {body(std::make_shared<PlaneShape>(Vec3{0.52, 0.55, 0.47}, way))};
        s.bodies[0].slip = slip;
        blow(s.bodies[0], U);
        const std::array<std::vector<double>, 3> nodes{uniform(0, 1, 9), graded_nodes(0, 1, 10, 1.05),
                                                       uniform(0, 1, 8)};
        prescribe(
            s, nodes, {true, true, true}, [&](const Vec3&) { return u; }, s.bodies[0].shape.get());
        s.side[kYlo] = {condition(BoundaryKind::kSlip)};  // behind the plane, or partly
        s.side[kYhi] = {condition(BoundaryKind::kPressure)};
        CfdBox box(nodes, {false, false, false}, s);
        auto uniform_flow = box.face_field();
        for (int d = 0; d < 3; ++d) uniform_flow[d].fill(u[d]);
        CellField<FineGrid> p(box.eps_begin.box());
        box.fluid->set_state(0, uniform_flow, p, box.eps_begin, 0, uniform_flow, box.eps_begin);
        for (int n = 0; n < 5; ++n) box.step(s.dt);
        double worst = 0, inside = 0;  // in all; two cells away from the sides
        for (int d = 0; d < 3; ++d)
          for_each(box.faces(d), [&](int i, int j, int k) {
            if (box.fluid->face_state(d)(i, j, k) != FaceState::kSolved) return;
            const double off = std::abs(box.fluid->velocity()[d](i, j, k) - u[d]) / U;
            worst = std::max(worst, off);
            const Int3 x{i, j, k};
            bool in = true;
            for (int e = 0; e < 3; ++e) in = in && x[e] >= 2 && x[e] < box.grid.axis[e].n() - 2 + (e == d);
            if (in) inside = std::max(inside, off);
          });
        worst = box.largest(worst), inside = box.largest(inside);
        report("plane %.1f %.1f %.1f, slip %d, implicit %d: off by %.1e, away from sides %.1e\n", way[0], way[1],
               way[2], int(slip), int(implicit), worst, inside);
        EXPECT_LT(worst, 0.01);
        EXPECT_LT(inside, 1e-3);
      }
}

/// Along a plate that blows with V, driven by a pressure gradient G, below an outlet: with E(y) = exp(V (y - h)/nu)
/// u = k (y - nu/V (E(y) - E(0))), k = -G/(rho V).
TEST(Blowing, ChannelWithCrossFlow) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral}) {
    double before = 0;
    for (int N : {12, 24}) {
      const double rho = 1.3, V = 0.8, G = -0.7, low = 0.137, h = 1 - low, nu = 0.25 * V * h;
      FluidSettings s;
      s.density = rho, s.viscosity = rho * nu;
      s.convection = scheme;
      s.pressure_rtol = 1e-9;
      s.dt = 0.4 / (N * V);
      s.pressure_gradient = {G, 0, 0};
      for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
      s.side[kXlo].clear(), s.side[kXhi].clear();
      s.side[kYhi] = {condition(BoundaryKind::kPressure)};
      s.bodies = {body(std::make_shared<PlaneShape>(Vec3{0, low, 0}, Vec3{0, 1, 0}))};
      blow(s.bodies[0], V);
      CfdBox box({uniform(0, 1, 4), uniform(0, 1, N), uniform(0, 1, 1)}, {true, false, false}, s);
      for (double t = 0; t < 12; t += s.dt) box.step(s.dt);
      const double k = -G / (rho * V), tail = std::exp(-V * h / nu);
      double error = 0, largest = 0, across = 0;
      const OpenShares& open = *box.fluid->open_shares();
      for_each(box.faces(0), [&](int i, int j, int l) {
        const std::ptrdiff_t m = open.theta().index(i, j, l);
        if (!(open.alpha(0, m) > 0) || open.sliver(0, m)) return;
        const double y0 = box.grid.axis[1].node(j),
                     y = 0.5 * (std::max(y0, low) + y0 + box.grid.axis[1].width(j)) - low,
                     u = k * (y - nu / V * (std::exp(V * (y - h) / nu) - tail));
        error = std::max(error, std::abs(box.fluid->velocity()[0](i, j, l) - u)), largest = std::max(largest, u);
      });
      for_each(box.faces(1), [&](int i, int j, int l) {
        if (box.fluid->face_state(1)(i, j, l) == FaceState::kSolved)
          across = std::max(across, std::abs(box.fluid->velocity()[1](i, j, l) - V));
      });
      error = box.largest(error) / box.largest(largest);
      report("channel with cross flow, convection %d, %d cells: off by %.2e of the largest, across %.1e m/s\n",
             int(scheme), N, error, box.largest(across));
      EXPECT_LT(box.largest(across), 1e-7);
      EXPECT_LT(error, N == 12 ? 0.02 : 0.006);
      EXPECT_LT(error, before > 0 ? 0.4 * before : 1);
      before = error;
    }
  }
}

/// What the fluid gains is what comes in less what the bodies take and what leaves: across the outlet, where no side has a
/// part in it; with velocities that change in time, bodies that blow on one side, and one that turns besides.
TEST(Blowing, Momentum) {
  for (int up : {2, 0, 1})
    for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
      for (Choice implicit : {Choice::kOff, Choice::kOn}) {
        FluidSettings s = tube_and_ball(scheme, implicit);
        const auto turned = [&](const Vec3& x) { return Vec3{x[(5 - up) % 3], x[(6 - up) % 3], x[(7 - up) % 3]}; };
        const auto back = [&](const Vec3& x) { return Vec3{x[(up + 1) % 3], x[(up + 2) % 3], x[up]}; };
        double now = 0;
        s.bodies = {
            body(std::make_shared<CylinderShape>(turned({0.31, 0, 0.36}), turned({0, 1, 0}), 0.13, FluidIs::kOutside)),
            body(std::make_shared<SphereShape>(turned({0.72, 0.52, 0.6}), 0.17, FluidIs::kOutside))};
        for (Body& b : s.bodies) b.blow.on = true;
        s.bodies[0].blow.where = [back](const Vec3& x) { return back(x)[0] > 0.3; };
        s.bodies[0].blow.velocity_now = [&now] { return 0.8 * (1 - std::exp(-80 * now)); };
        s.bodies[1].blow.where = [back](const Vec3& x) { return back(x)[1] + 0.5 * back(x)[0] < 0.9; };
        s.bodies[1].blow.velocity_now = [&now] { return 0.5 + 0.2 * std::sin(300 * now); };
        s.bodies[0].motion.turning = turned({0, 9, 0}), s.bodies[0].motion.origin = turned({0.31, 0, 0.36});
        s.side[2 * up + 1] = {condition(BoundaryKind::kPressure)};
        std::array<bool, 3> periodic{true, true, true};
        std::array<std::vector<double>, 3> nodes{uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)};
        for (int d = 0; d < 3; ++d)
          if (d != up) s.side[2 * d].clear(), s.side[2 * d + 1].clear();
        periodic[up] = false;
        CfdBox box(nodes, periodic, s);
        FaceField<FineGrid> last[3];
        double worst = 0, given = 0, taken = 0;
        Vec3 before{0, 0, 0};
        for (int step = 0; step < 10; ++step) {
          for (int q = 2; q > 0; --q) last[q] = last[q - 1];
          last[0] = box.fluid->velocity();
          now += s.dt;
          box.step(s.dt);
          const Vec3 total = box.fluid->total_momentum(), pending = box.fluid->pending_momentum();
          for (int c = 0; c < 3; ++c) {
            if (c == up || step < 3) continue;
            double leaves = 0;
            const auto at = [&](int d, std::ptrdiff_t m) {
              const double a = last[0][d].data()[m], b = last[1][d].data()[m], e = last[2][d].data()[m];
              return scheme == Convection::kCentral ? 2.5 * a - 2 * b + 0.5 * e : 2 * a - b;
            };
            const int top = box.grid.axis[up].n();
            for_each(box.faces(c), [&](int i, int j, int k) {
              Int3 x{i, j, k};
              if (x[up] != top - 1) return;
              const std::ptrdiff_t m = last[0][c].index(i, j, k), out = m + last[0][c].stride(up);
              leaves += s.density * 0.5 * (at(up, out) + at(up, out - last[0][c].stride(c))) *
                        box.grid.area(up, i, j, k) * at(c, m);
            });
            double all = -box.sum(leaves);
            for (const BodyForce& b : box.fluid->body_forces()) {
              all += b.carried[c] - b.force()[c];
              given = std::max(given, std::abs(b.carried[c])), taken = std::max(taken, std::abs(b.force()[c]));
            }
            worst = std::max(worst, std::abs((total[c] + pending[c] - before[c]) / s.dt - all));
          }
          for (int c = 0; c < 3; ++c) before[c] = total[c] + pending[c];
        }
        report(
            "blowing bodies, outlet along %d, convection %d, implicit %d: carried in %.3e N, on a body %.3e N, missing "
            "%.1e N\n",
            up, int(scheme), int(implicit), given, taken, worst);
        EXPECT_GT(given, 0.002);
        EXPECT_LT(worst, (implicit == Choice::kOn ? 1e-8 : 1e-11) * taken);
      }
}
