// Walls that move along themselves: drums, inner cylinders, belts. Without these, friction that a rigid motion of fluid
// and walls together would feel, a wall that drags the fluid too little or too much, a torque that lacks the share of
// turning streamlines (39 % of it), or momentum that moving walls make would pass.
#include <gtest/gtest.h>

#include "cfd/bodies/wall_stress.h"
#include "cfd/fluid/predictor.h"
#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

/// The open part's centre of a face, by points on it; its own centre where the grid's edges are too coarse for a surface.
Vec3 open_centre(const CfdBox& box, const std::vector<Body>& bodies, int d, const Int3& face) {
  constexpr int kPoints = 60;
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  Vec3 x = box.face(d, face[0], face[1], face[2]), sum{0, 0, 0};
  const double e0 = x[e], f0 = x[f], we = box.grid.axis[e].width(face[e]), wf = box.grid.axis[f].width(face[f]);
  int open = 0;
  for (int i = 0; i < kPoints; ++i)
    for (int j = 0; j < kPoints; ++j) {
      x[e] = e0 + ((i + 0.5) / kPoints - 0.5) * we, x[f] = f0 + ((j + 0.5) / kPoints - 0.5) * wf;
      bool solid = false;
      for (const Body& b : bodies) solid = solid || b.shape->side(x) == SolidShape::Side::kSolid;
      if (solid) continue;
      for (int q = 0; q < 3; ++q) sum[q] += x[q];
      ++open;
    }
  x[e] = e0, x[f] = f0;
  if (open > 0)
    for (int q = 0; q < 3; ++q) x[q] = sum[q] / open;
  return x;
}

SurfaceMotion motion(const Vec3& velocity, const Vec3& turning) {
  SurfaceMotion m;
  m.velocity = velocity, m.turning = turning, m.origin = {0.3, 0.8, 0.1};
  return m;
}

/// Largest change of u = u_r by viscous forces in one step, over that which the walls would make if they stood.
double strain_of_rigid_motion(const SurfaceMotion& m, bool implicit, double eps, bool varying) {
  FluidSettings s = creeping(0.05);
  s.implicit_viscosity = implicit ? Choice::kOn : Choice::kOff;
  s.bodies = {body(std::make_shared<SphereShape>(Vec3{0.51, 0.48, 0.52}, 0.4, FluidIs::kInside), "vessel"),
              body(std::make_shared<SphereShape>(Vec3{0.47, 0.55, 0.5}, 0.15, FluidIs::kOutside), "ball")};
  double largest[2];
  for (bool moves : {false, true}) {
    for (Body& b : s.bodies) b.motion = moves ? m : SurfaceMotion{};
    CfdBox box({uniform(0, 1, 13), graded_nodes(0, 1, 14, 1.04), uniform(0, 1, 12)}, {false, false, false}, s);
    FluidDomain domain(box.comm(), box.grid, box.layout, s);
    Predictor predictor(domain, s);
    auto u = box.face_field();
    double misplaced = 0;
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d), [&](int i, int j, int k) {
        const OpenShares& open = *domain.measures.open();
        const std::ptrdiff_t q = u[d].index(i, j, k);
        if (!(open.alpha(d, q) > 0)) return;
        const Vec3 centre = box.face(d, i, j, k);
        u[d](i, j, k) = m.at(centre)[d];
        if (!(open.alpha(d, q) < 1) || !moves) return;
        u[d](i, j, k) = open.wall_velocity(d, q);
        misplaced = std::max(misplaced, std::abs(u[d](i, j, k) - m.at(open_centre(box, s.bodies, d, {i, j, k}))[d]));
      });
    box.set(box.eps_begin, [eps](double, double, double) { return eps; });
    CellField<FineGrid> p(box.eps_begin.box());
    box.fluid->set_state(0, u, p, box.eps_begin, 0, u, box.eps_begin);
    FluidState state = box.fluid->state();
    Step step{0.05, 0, 1, -1, 0};
    step.implicit_viscosity = implicit;
    FluidProperties properties;
    properties.viscosity.number = 1;
    if (varying) {
      auto& mu = properties.viscosity.vary(domain.local);
      box.set(mu, [](double x, double y, double z) { return 1 + 0.8 * std::sin(7 * x + 5 * y) * std::cos(6 * z); });
    }
    FaceField<FineGrid> tilde = box.face_field(), next = box.face_field();
    predictor.extrapolate(state, step, tilde);
    predictor.predict(state, step, properties, Interphase{}, tilde, next);
    largest[moves] = 0;
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d), [&](int i, int j, int k) {
        if (box.fluid->face_state(d)(i, j, k) != FaceState::kSolved) return;
        largest[moves] = std::max(largest[moves], std::abs(next[d](i, j, k) - state.u[d](i, j, k)));
      });
    largest[moves] = box.largest(largest[moves]);
    // Where the velocities of cut faces are; chords stand for the ball's arcs.
    EXPECT_LT(box.largest(misplaced), 0.03);
  }
  return largest[1] / largest[0];
}

}  // namespace

/// Fluid and walls that move together as one rigid body: no row feels anything, whole, cut or a sliver.
TEST(MovingWalls, RigidMotionIsWithoutFriction) {
  const SurfaceMotion along = motion({0.7, -0.4, 1.1}, {0, 0, 0}), turning = motion({0, 0, 0}, {0.9, -1.3, 0.5}),
                      both = motion({0.7, -0.4, 1.1}, {0.9, -1.3, 0.5});
  for (const SurfaceMotion* m : {&along, &turning, &both})
    for (bool implicit : {false, true})
      for (bool varying : {false, true}) {
        const double strain = strain_of_rigid_motion(*m, implicit, varying ? 1 : 0.6, varying);
        report("rigid motion, implicit %d, viscosity varies %d: %.1e of what walls at rest do\n", int(implicit),
               int(varying), strain);
        EXPECT_LT(strain, implicit ? 1e-8 : 1e-13);  // implicit: the solver's tolerance is 1e-10
      }
}

namespace {

/// Between a cylinder that turns and one at rest, whichever: u = C (b^2/r - r), b the radius of that at rest; torque
/// 4 pi mu w r1^2 r2^2/(r2^2 - r1^2) a length.
struct Couette {
  double error, torque, other, force;  // all relative
  double facets[2];  // torques by the friction on facets (wall_stress.h): of the one that turns, of the other
};
Couette rotating_couette(int along, int N, bool outer, int salt) {
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  const double r1 = 0.2, r2 = 0.42, w = 1.5, part = r2 * r2 - r1 * r1;
  FluidSettings s = creeping(10);
  Vec3 centre{0, 0, 0}, axis{0, 0, 0};
  axis[along] = 1;
  centre[e] = 0.5 + (random_number(2 * salt) - 0.5) / N, centre[f] = 0.5 + (random_number(2 * salt + 1) - 0.5) / N;
  s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, r1, FluidIs::kOutside), "inner"),
              body(std::make_shared<CylinderShape>(centre, axis, r2, FluidIs::kInside), "outer")};
  s.bodies[outer].motion.turning[along] = w, s.bodies[outer].motion.origin = centre;
  std::array<std::vector<double>, 3> nodes;
  nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 1, N), nodes[along] = uniform(0, 1.0 / N, 1);
  s.wall_stress = true;
  CfdBox box(nodes, {false, false, false}, s);
  for (int n = 0; n < 4; ++n) box.step(s.dt);
  double sum[2] = {0, 0};
  for (int c : {e, f})
    for_each(box.faces(c), [&](int i, int j, int k) {
      const double V = box.fluid->measures().open_volume(c, i, j, k);
      if (box.fluid->face_state(c)(i, j, k) != FaceState::kSolved || !(V > 0)) return;
      const Vec3 x = open_centre(box, s.bodies, c, {i, j, k});
      const double a = x[e] - centre[e], b = x[f] - centre[f], r = std::hypot(a, b);
      const double turning = outer ? w * r2 * r2 / part * (r - r1 * r1 / r) : w * r1 * r1 / part * (r2 * r2 / r - r),
                   d = box.fluid->velocity()[c](i, j, k) - turning * (c == e ? -b : a) / r;
      sum[0] += V * d * d, sum[1] += V;
    });
  const double wanted = 4 * kPi * w * r1 * r1 * r2 * r2 / part / N, speed = w * (outer ? r2 : r1);
  const auto& forces = box.fluid->body_forces();
  Couette result{std::sqrt(box.sum(sum[0]) / box.sum(sum[1])) / speed,
                 -forces[outer].torque_about(centre)[along] / wanted - 1,
                 forces[!outer].torque_about(centre)[along] / wanted - 1,
                 std::hypot(forces[outer].force()[e], forces[outer].force()[f]) * r1 / wanted,
                 {0, 0}};
  const WallStress& wall = *box.fluid->wall_stress();
  for (std::size_t q = 0; q < wall.facets().size(); ++q) {
    const WallFacet& facet = wall.facets()[q];
    const Vec3 t = wall.friction(q);
    result.facets[facet.body != outer] +=
        facet.area / wanted * ((facet.centre[e] - centre[e]) * t[f] - (facet.centre[f] - centre[f]) * t[e]);
  }
  for (double& torque : result.facets) torque = box.sum(torque);
  result.facets[0] = -result.facets[0] - 1, result.facets[1] -= 1;
  report(
      "%s cylinder turns along %d, %.1f cells in the gap, place %d: velocity %.2e, torque on it %+.2f %%, on the other "
      "%+.2f %%, "
      "force %.1e; by facets %+.2f and %+.2f %%\n",
      outer ? "outer" : "inner", along, N * (r2 - r1), salt, result.error, 100 * result.torque, 100 * result.other,
      result.force, 100 * result.facets[0], 100 * result.facets[1]);
  return result;
}

}  // namespace

TEST(MovingWalls, RotatingCouette) {
  for (bool outer : {false, true})
    for (int along : {2, 0, 1}) {
      double error[3] = {0, 0, 0};
      constexpr double kTorque[3] = {0.06, 0.03, 0.02};
      for (int fine = 0; fine < 3; ++fine)
        for (int salt = 0; salt < 3; ++salt) {
          const Couette c = rotating_couette(along, 16 << fine, outer, 3 * along + salt);
          error[fine] += c.error * c.error;
          EXPECT_LT(std::abs(c.torque), kTorque[fine]);
          EXPECT_LT(std::abs(c.other), kTorque[fine]);
          for (double by_facets : c.facets) EXPECT_LT(std::abs(by_facets), kTorque[fine]);
        }
      const double order = 0.25 * std::log2(error[0] / error[2]);
      report("order %.2f\n", order);
      EXPECT_GT(order, 1.4);
    }
}

namespace {

/// One wall of ducts at an angle to the grid in x and y, |s| < half with s = x sin - y cos, and its images a period of 1 apart.
class DuctWall : public SolidShape {
 public:
  DuctWall(double degrees, double centre, double half, bool upper)
      : normal_{std::sin(degrees * kPi / 180), -std::cos(degrees * kPi / 180), 0},
        centre_(centre),
        half_(half),
        wall_(upper ? half : -half) {}
  double first_crossing(const Vec3& x, int d, double length) const override {
    const double s = height(x), change = normal_[d] * length;
    double first = kNone;
    for (int image = -3; image <= 3 && change != 0; ++image) {
      const double share = (wall_ + image - s) / change;
      if (share >= 0 && share <= 1) first = std::min(first, share);
    }
    return first;
  }
  double distance(const Vec3& x, double, Vec3& nearest) const override {
    double out = wall_ - height(x);
    out -= std::round(out);
    for (int d = 0; d < 3; ++d) nearest[d] = x[d] + out * normal_[d];
    return std::abs(out);
  }
  Side side(const Vec3& x) const override { return std::abs(height(x)) < half_ ? Side::kFluid : Side::kSolid; }

 private:
  double height(const Vec3& x) const {
    const double s = normal_[0] * x[0] + normal_[1] * x[1] - centre_;
    return s - std::round(s);
  }
  Vec3 normal_;
  double centre_, half_, wall_;
};

}  // namespace

/// Shear between a belt and a wall is linear, at any angle to the grid.
TEST(MovingWalls, Belt) {
  for (double degrees : {30.0, 20.0}) {
    const double half = 0.3, U = 0.7, sine = std::sin(degrees * kPi / 180), cosine = std::cos(degrees * kPi / 180);
    constexpr int N = 12;
    const double centre = random_number(3) / N;
    FluidSettings s = creeping(10);
    s.bodies = {body(std::make_shared<DuctWall>(degrees, centre, half, false), "wall"),
                body(std::make_shared<DuctWall>(degrees, centre, half, true), "belt")};
    s.bodies[1].motion.velocity = {U * cosine, U * sine, 0};
    for (int side = 0; side < 4; ++side) s.side[side].clear();
    CfdBox box({uniform(0, 1 / sine, int(std::lround(N / sine))), uniform(0, 1 / cosine, int(std::lround(N / cosine))),
                uniform(0, 1.0 / N, 1)},
               {true, true, false}, s);
    for (int n = 0; n < 4; ++n) box.step(s.dt);
    double worst = 0, open = 0, square[2] = {0, 0};
    const OpenShares& shares = *box.fluid->open_shares();
    for_each(box.own(), [&](int i, int j, int k) { open += shares.theta()(i, j, k) * box.grid.volume(i, j, k); });
    for (int c : {0, 1})
      for_each(box.faces(c), [&](int i, int j, int k) {
        if (box.fluid->face_state(c)(i, j, k) != FaceState::kSolved) return;
        const Vec3 x = open_centre(box, s.bodies, c, {i, j, k});
        double height = x[0] * sine - x[1] * cosine - centre;
        height -= std::round(height);
        const double u = U * (height + half) / (2 * half) * (c == 0 ? cosine : sine),
                     off = box.fluid->velocity()[c](i, j, k) - u, V = box.fluid->measures().open_volume(c, i, j, k);
        square[0] += off * off * V, square[1] += V;
        if (!shares.sliver(c, shares.theta().index(i, j, k))) worst = std::max(worst, std::abs(off));
      });
    worst = box.largest(worst);
    const double rms = std::sqrt(box.sum(square[0]) / box.sum(square[1]));
    const double wanted = U / (2 * half) * box.sum(open) / (2 * half);
    const Vec3 at_wall = box.fluid->body_forces()[0].force(), at_belt = box.fluid->body_forces()[1].force();
    const double on_wall = (at_wall[0] * cosine + at_wall[1] * sine) / wanted - 1,
                 on_belt = -(at_belt[0] * cosine + at_belt[1] * sine) / wanted - 1;
    report("belt at %.0f degrees: velocity off by %.1e, %.1e where most, force on it %+.3f %%, on the wall %+.3f %%\n",
           degrees, rms / U, worst / U, 100 * on_belt, 100 * on_wall);
    EXPECT_LT(worst, 0.02 * U);
    EXPECT_LT(std::abs(on_belt), 0.01);
    EXPECT_LT(std::abs(on_wall), 0.01);
  }
}

/// A periodic box with a tube and a ball that turn, and where they touch cells of a third body at rest: what the fluid gains is what
/// the bodies give.
TEST(MovingWalls, MomentumOfAPeriodicBox) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral, Convection::kNone})
    for (Choice implicit : {Choice::kOff, Choice::kOn}) {
      FluidSettings s = tube_and_ball(scheme, implicit);
      for (auto& side : s.side) side.clear();
      const auto ball = [](const Vec3& at, const char* name) {
        return body(std::make_shared<SphereShape>(at, 0.17, FluidIs::kOutside), name);
      };
      s.bodies[1] = ball({0.72, 0.52, 0.95}, "ball");
      s.bodies.push_back(ball({0.65, 0.5, 0.45}, "at rest"));
      s.bodies[0].motion.turning = {0, 20, 0}, s.bodies[0].motion.origin = {0.31, 0, 0.36};
      s.bodies[0].motion.velocity = {0, 0.5, 0};
      s.bodies[1].motion.turning = {5, -9, 7}, s.bodies[1].motion.origin = {0.72, 0.52, 0.95};
      CfdBox box({uniform(0, 1, 12), uniform(0, 1, 10), uniform(0, 1, 14)}, {true, true, true}, s);
      double worst = 0, given = 0;
      Vec3 before{0, 0, 0};
      for (int step = 0; step < 12; ++step) {
        box.step(s.dt);
        const Vec3 total = box.fluid->total_momentum(), pending = box.fluid->pending_momentum();
        for (int d = 0; d < 3; ++d) {
          double taken = 0;
          for (const BodyForce& b : box.fluid->body_forces())
            taken += b.force()[d], given = std::max(given, std::abs(b.force()[d]));
          const double now = total[d] + pending[d];
          if (step > 0) worst = std::max(worst, std::abs((now - before[d]) / s.dt + taken));
          before[d] = now;
        }
      }
      const Vec3 torque = box.fluid->body_forces()[0].torque;
      report("turning bodies, convection %d, implicit %d: force %.3e N, torque %.2e N m, missing %.1e N\n", int(scheme),
             int(implicit), given, torque[1], worst);
      EXPECT_LT(torque[1], 0);
      EXPECT_LT(worst, (implicit == Choice::kOn ? 1e-8 : 1e-11) * given);
    }
}
