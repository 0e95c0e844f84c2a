// Friction and pressure place by place on the surfaces of bodies (cfd/bodies/wall_stress.h). Without these, a derivative
// that takes a curved wall for a plane, velocities for those of other places, a small facet's for less than a large one's,
// areas that are not those of the wall, or a pressure taken from the cell in place of the wall would pass.
#include <gtest/gtest.h>

#include "cfd/bodies/wall_stress.h"
#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"
#include "tests/verification/oblique_ducts.h"

using namespace twogrid;

namespace {

/// Over all facets, each counting the same: means of the friction along a direction, of its deviation (root mean square),
/// and its largest; all over what is wanted. sum: of friction times area (N).
struct Scatter {
  double mean = 0, deviation = 0, largest = 0, area = 0, across = 0, sum = 0;
};
Scatter friction_along(const CfdBox& box, const Vec3& n, double wanted) {
  const WallStress& w = *box.fluid->wall_stress();
  Scatter s;
  for (std::size_t q = 0; q < w.facets().size(); ++q) {
    const Vec3 t = w.friction(q);
    const double A = w.facets()[q].area, along = t[0] * n[0] + t[1] * n[1] + t[2] * n[2];
    s.area += A, s.sum += A * along, s.mean += along, s.deviation += (along - wanted) * (along - wanted);
    s.largest = std::max(s.largest, std::abs(along / wanted - 1));
    s.across += std::max(0.0, t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - along * along);
  }
  const double facets = box.sum(double(w.facets().size()));
  s.area = box.sum(s.area), s.sum = box.sum(s.sum), s.mean = box.sum(s.mean) / (facets * wanted);
  s.deviation = std::sqrt(box.sum(s.deviation) / facets) / wanted, s.largest = box.largest(s.largest);
  s.across = std::sqrt(box.sum(s.across) / facets) / wanted;
  return s;
}

}  // namespace

/// Developed flow: G R/2 on all places of a pipe.
TEST(WallStress, Pipe) {
  for (int along : {0, 1, 2})
    for (int N : {16, 32}) {
      const int e = (along + 1) % 3, f = (along + 2) % 3;
      const double R = 0.42, wanted = R / 2;
      FluidSettings s = creeping(10);
      s.pressure_gradient[along] = -1;
      s.side[2 * along].clear(), s.side[2 * along + 1].clear();
      Vec3 centre{0, 0, 0}, axis{0, 0, 0};
      axis[along] = 1;
      centre[e] = 0.5 + (random_number(along) - 0.5) / N, centre[f] = 0.5 + (random_number(along + 4) - 0.5) / N;
      s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, R, FluidIs::kInside), "pipe")};
      s.wall_stress = true;
      std::array<std::vector<double>, 3> nodes;
      std::array<bool, 3> periodic{false, false, false};
      periodic[along] = true;
      nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 1, N), nodes[along] = uniform(0, 4.0 / N, 4);
      CfdBox box(nodes, periodic, s);
      EXPECT_GT(until_steady(box, along, s.dt, 1e-7, 50), 0);
      const Scatter t = friction_along(box, axis, wanted);
      const double area = t.area / (2 * kPi * R * 4.0 / N) - 1;
      const double force = box.fluid->body_forces()[0].force()[along];
      report(
          "pipe along %d, %.1f cells across: friction %+.3f %% of G R/2, area %+.3f %%; facets: %.2f %% rms, %.2f %% "
          "at most, across %.1e; sum against the force %+.3f %%\n",
          along, 2 * R * N, 100 * (t.mean - 1), 100 * area, 100 * t.deviation, 100 * t.largest, t.across,
          100 * (t.sum / force - 1));
      EXPECT_LT(t.deviation, N == 32 ? 0.01 : 0.015);
      EXPECT_LT(t.largest, N == 32 ? 0.025 : 0.04);
      EXPECT_LT(std::abs(t.sum / force - 1), N == 32 ? 0.004 : 0.005);
    }
}

/// At an angle to the grid: G times half the width everywhere.
TEST(WallStress, DuctAtAnAngle) {
  for (int thin : {0, 1, 2})
    for (int N : {12, 24}) {
      Duct duct(thin, N, 30, thin);
      duct.s.wall_stress = true;
      CfdBox box = duct.box();
      EXPECT_GT(until_steady(box, duct.x, 10, 1e-6, 60), 0);
      Vec3 n{0, 0, 0};
      n[duct.x] = duct.cosine, n[duct.y] = duct.sine;
      const Scatter t = friction_along(box, n, Duct::half);
      // G times the duct's volume, drawn and resolved: the force on its walls by the balance of momentum, too.
      const double all = Duct::half / (duct.sine * duct.cosine) * 2 / N;
      const double volume = open_volume(box);
      const BodyForce& b = box.fluid->body_forces()[0];
      const double force = b.force()[duct.x] * duct.cosine + b.force()[duct.y] * duct.sine,
                   across = b.force()[duct.x] * duct.sine - b.force()[duct.y] * duct.cosine;
      EXPECT_NEAR(force / volume, 1, 1e-4);
      EXPECT_NEAR(across / volume, 0, 1e-4);
      report(
          "duct across %d, %.1f cells: friction %+.3f %%; facets: %.2f %% rms, %.2f %% at most; sum "
          "%+.3f %%, by momentum %+.1e\n",
          thin, 2 * Duct::half * N, 100 * (t.mean - 1), 100 * t.deviation, 100 * t.largest, 100 * (t.sum / all - 1),
          force / volume - 1);
      EXPECT_LT(t.deviation, N == 24 ? 1e-3 : 2e-3);
      EXPECT_LT(t.largest, N == 24 ? 3e-3 : 5e-3);
      EXPECT_LT(std::abs(t.sum / all - 1), 2e-3);
    }
}

/// A tube and a ball: closed surfaces whose outlines are their areas, and, whatever a facet's area, the exact slope of what
/// the fits hold exactly.
TEST(WallStress, TubeAndBall) {
  FluidSettings s = creeping(1);
  for (auto& side : s.side) side.clear();
  s.bodies = {
      body(std::make_shared<CylinderShape>(Vec3{0.31, 0, 0.36}, Vec3{0, 1, 0}, 0.13, FluidIs::kOutside), "tube"),
      body(std::make_shared<SphereShape>(Vec3{0.97, 0.52, 0.7}, 0.17, FluidIs::kOutside), "ball")};
  s.wall_stress = true;
  CfdBox box({uniform(0, 1, 16), uniform(0, 1, 14), uniform(0, 1, 18)}, {true, true, true}, s);
  WallStress& w = *box.fluid->wall_stress();
  const OpenShares& open = *box.fluid->open_shares();
  const auto distance = [](Vec3 x) {
    for (double& a : x) a -= std::floor(a);
    const double tube = std::hypot(x[0] - 0.31, x[2] - 0.36) - 0.13, a = x[0] - 0.97 + (x[0] < 0.47 ? 1 : 0);
    return std::min(tube, std::sqrt(a * a + std::pow(x[1] - 0.52, 2) + std::pow(x[2] - 0.7, 2)) - 0.17);
  };
  FaceField<FineGrid> u = box.face_field();
  for (int c = 0; c < 3; ++c)
    for_each(u[c].box(), [&](int i, int j, int k) {
      const double n = distance(box.face(c, i, j, k));
      // That of the open part, of which the centre has its share.
      u[c](i, j, k) = (2 + c) * n * (1 - 3 * n + 4 * n * n) / open.centre(c, u[c].index(i, j, k));
    });
  double area[2] = {0, 0}, closed[6] = {}, bent = 0, steep = 0;
  for (std::size_t q = 0; q < w.facets().size(); ++q) {
    const WallFacet& f = w.facets()[q];
    area[f.body] += f.area;
    for (int d = 0; d < 3; ++d) closed[3 * f.body + d] += f.area * f.normal[d];
    Vec3 sum{0, 0, 0};
    for (std::size_t a = 0; a < f.corners.size(); ++a) {
      const Vec3 &x = f.corners[a], &y = f.corners[(a + 1) % f.corners.size()];
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        sum[d] += 0.5 * ((x[e] - f.centre[e]) * (y[g] - f.centre[g]) - (x[g] - f.centre[g]) * (y[e] - f.centre[e]));
      }
    }
    for (int d = 0; d < 3; ++d) bent = std::max(bent, std::abs(sum[d] - f.area * f.normal[d]) * 256);
    const Vec3 slope = w.slope(q, u);
    for (int c = 0; c < 3; ++c) steep = std::max(steep, std::abs(slope[c] / (2 + c) - 1));
  }
  for (double& a : area) a = box.sum(a);
  double apart = 0;
  for (double c : closed) apart = std::max(apart, std::abs(box.sum(c)));
  bent = box.largest(bent), steep = box.largest(steep);
  report(
      "tube and ball: area %+.2f %% and %+.2f %%, sum of area times normal %.1e m2, outlines apart %.1e of a cell's "
      "side; slope %.1e\n",
      100 * (area[0] / (2 * kPi * 0.13) - 1), 100 * (area[1] / (4 * kPi * 0.17 * 0.17) - 1), apart, bent, steep);
  EXPECT_LT(apart, 1e-13);
  EXPECT_LT(bent, 1e-12);
  EXPECT_LT(steep, 1e-5);
  EXPECT_NEAR(area[0] / (2 * kPi * 0.13), 1, 0.03);
  EXPECT_NEAR(area[1] / (4 * kPi * 0.17 * 0.17), 1, 0.04);
}

/// Stokes' formulas around a ball at rest, U along z: friction 3/2 mu U/R sin(theta), pressure -3/2 mu U/R cos(theta), put
/// into the fits as they are; force 6 pi mu U R.
TEST(WallStress, BallOfStokes) {
  for (int N : {18, 36}) {
    const double R = 0.36;
    const Vec3 o{0.507, 0.489, 0.513};
    FluidSettings s = creeping(1);
    s.bodies = {body(std::make_shared<SphereShape>(o, R, FluidIs::kOutside))};
    s.wall_stress = true;
    CfdBox box({uniform(0, 1, N), uniform(0, 1, N), uniform(0, 1, N)}, {false, false, false}, s);
    WallStress& w = *box.fluid->wall_stress();
    const OpenShares& open = *box.fluid->open_shares();
    FaceField<FineGrid> u = box.face_field();
    CellField<FineGrid> p(box.fluid->pressure().box());
    for (int c = 0; c < 3; ++c)
      for_each(u[c].box(), [&](int i, int j, int k) {
        Vec3 x = box.face(c, i, j, k);
        for (int d = 0; d < 3; ++d) x[d] -= o[d];
        const double r = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), a = R / r;
        const double v =
            (c == 2 ? 1 - 0.75 * a - 0.25 * a * a * a : 0.0) - 0.75 * a * (1 - a * a) * x[2] * x[c] / (r * r);
        u[c](i, j, k) = v / open.centre(c, u[c].index(i, j, k));
      });
    for_each(p.box(), [&](int i, int j, int k) {
      Vec3 x = box.cell(i, j, k);
      for (int d = 0; d < 3; ++d) x[d] -= o[d];
      p(i, j, k) = -1.5 * R * x[2] / std::pow(x[0] * x[0] + x[1] * x[1] + x[2] * x[2], 1.5);
    });
    w.take(p);
    double apart[4] = {0, 0, 0, 0}, force[2] = {0, 0};
    for (std::size_t q = 0; q < w.facets().size(); ++q) {
      const WallFacet& f = w.facets()[q];
      const Vec3 slope = w.slope(q, u);
      Vec3 n;
      double r = 0, through = 0, square = 0;
      for (int d = 0; d < 3; ++d) n[d] = f.centre[d] - o[d], r += n[d] * n[d];
      for (int d = 0; d < 3; ++d) n[d] /= std::sqrt(r), through += slope[d] * n[d];
      for (int d = 0; d < 3; ++d) {
        const double t = slope[d] - through * n[d], wanted = 1.5 / R * ((d == 2) - n[2] * n[d]);
        square += (t - wanted) * (t - wanted);
        if (d == 2) force[0] += f.area * t;
      }
      const double at_wall = w.pressure(q), off = at_wall + 1.5 / R * n[2];
      force[1] -= f.area * at_wall * f.normal[2];
      apart[0] += square, apart[1] = std::max(apart[1], square), apart[2] += off * off,
                          apart[3] = std::max(apart[3], std::abs(off));
    }
    // A pressure of second degree is held exactly, wherever the grid cuts.
    const auto bent = [](const Vec3& x) {
      return 3 + x[0] - 2 * x[1] + 0.5 * x[2] + x[0] * x[0] - 3 * x[0] * x[1] + 2 * x[2] * x[2] + x[1] * x[2];
    };
    for_each(p.box(), [&](int i, int j, int k) { p(i, j, k) = bent(box.cell(i, j, k)); });
    w.take(p);
    double held = 0;
    for (std::size_t q = 0; q < w.facets().size(); ++q) {
      Vec3 x = w.facets()[q].centre;
      double r = 0;
      for (int d = 0; d < 3; ++d) r += (x[d] - o[d]) * (x[d] - o[d]);
      for (int d = 0; d < 3; ++d) x[d] = o[d] + (x[d] - o[d]) * R / std::sqrt(r);
      held = std::max(held, std::abs(w.pressure(q) - bent(x)));
    }
    held = box.largest(held);
    const double all = box.sum(double(w.facets().size()));
    for (int q : {0, 2}) apart[q] = std::sqrt(box.sum(apart[q]) / all);
    apart[1] = std::sqrt(box.largest(apart[1])), apart[3] = box.largest(apart[3]);
    for (double& a : apart) a /= 1.5 / R;
    const double drag = box.sum(force[0]) / (4 * kPi * R) - 1, form = box.sum(force[1]) / (2 * kPi * R) - 1;
    report(
        "ball, %.0f cells across: friction %.2f %% rms, %.2f %% at most, pressure %.2f %%, %.2f %% of the largest; "
        "forces "
        "%+.2f %%, %+.2f %%; second degree held to %.1e\n",
        2 * R * N, 100 * apart[0], 100 * apart[1], 100 * apart[2], 100 * apart[3], 100 * drag, 100 * form, held);
    EXPECT_LT(held, 1e-5);
    EXPECT_LT(apart[0], N == 18 ? 0.03 : 0.01);
    EXPECT_LT(apart[2], N == 18 ? 0.03 : 0.01);
    EXPECT_LT(std::abs(drag), N == 18 ? 0.03 : 0.01);
    EXPECT_LT(std::abs(form), N == 18 ? 0.03 : 0.01);
  }
}
