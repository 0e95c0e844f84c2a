// Faces and areas of patches.
// What would pass falsely without it: a report, a balance of inlets, or a check that counts other faces than the solver
// blows through; a patch snapped to twice its area without a word, a region that lies between the points that are looked at; a parabolic inlet on few cells whose mean velocity is
// not the one that the script gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cfd/boundary/boundaries.h"
#include "cfd/boundary/patches.h"
#include "cfd/boundary/region_outline.h"
#include "cfd/parallel/ranks.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/script_parser.h"

namespace twogrid {
namespace {

FluidSettings fluid_with(const PatchShape& shape) {
  FluidSettings f;
  f.density = 1, f.viscosity = 1e-3;
  for (auto& side : f.side) side.resize(1);
  BoundaryCondition jet;
  jet.name = "jet", jet.kind = BoundaryKind::kInlet, jet.shape = shape, jet.velocity = {0, 0, 1};
  f.side[kZlo].push_back(jet);
  f.side[kZhi][0].kind = BoundaryKind::kPressure;
  return f;
}

FineGrid box_of(int n, double L) {
  FineGrid g;
  for (int d = 0; d < 2; ++d) g.axis[d] = Axis(graded_nodes(0, L, n), false);
  g.axis[2] = Axis(graded_nodes(0, L, 8), false);
  return g;
}

/// The jet as the solver's own conditions have it, of all ranks.
PatchArea solved(const FluidSettings& f, const FineGrid& g) {
  const int ranks = ranks_of(MPI_COMM_WORLD);
  std::array<std::vector<int>, 3> cuts;
  for (int d = 0; d < 3; ++d) cuts[d] = {0, g.axis[d].n()};
  cuts[2].clear();
  for (int r = 0; r <= ranks; ++r) cuts[2].push_back(r * g.axis[2].n() / ranks);
  return Boundaries(MPI_COMM_WORLD, g, Layout(g, cuts), f).areas(MPI_COMM_WORLD).at(0);
}

TEST(Patches, SolverAndReportCountTheSameFaces) {
  // A circle about a face's centre with a radius of whole cells: faces exactly on it, where any rounding decides.
  const int n = 64;
  const double L = 0.01, h = L / n;
  const FineGrid g = box_of(n, L);
  int on_the_edge = 0;
  for (double R : {13, 5, 10, 17, 25}) {
    PatchShape circle;
    circle.kind = PatchShape::Kind::kCircle;
    circle.value = {32.5 * h, 32.5 * h, R * h, 0};
    const FluidSettings f = fluid_with(circle);
    const double area = solved(f, g).area, reported = patch_sizes(f, kZlo, g)[1].open;
    EXPECT_EQ(std::lround(area / (h * h)), std::lround(reported / (h * h))) << R;
    // Those inside for sure, and those on the edge: the count lies between.
    int inside = 0, edge = 0;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int q = (i - 32) * (i - 32) + (j - 32) * (j - 32);
        inside += q < R * R, edge += q == R * R;
      }
    EXPECT_GE(std::lround(area / (h * h)), inside);
    EXPECT_LE(std::lround(area / (h * h)), inside + edge);
    on_the_edge += edge;
  }
  EXPECT_GT(on_the_edge, 40);
}

TEST(Patches, DrawnTakenAndOpenAreas) {
  const FineGrid g = box_of(10, 0.01);
  PatchShape slot;
  slot.kind = PatchShape::Kind::kRectangle;
  slot.value = {0.0024, 0.0056, 0, 0.01};  // 3.2 cells wide, the centres of 2.5, 3.5 and 4.5, 5.5 lie in it: 4
  FluidSettings f = fluid_with(slot);
  PatchSize size = patch_sizes(f, kZlo, g)[1];
  EXPECT_NEAR(size.drawn, 3.2e-5, 1e-18);
  EXPECT_NEAR(size.faces, 4e-5, 1e-18);
  EXPECT_NEAR(size.open, 4e-5, 1e-18);
  EXPECT_NEAR(patch_sizes(f, kZlo, g)[0].open, 6e-5, 1e-18);
  BoundaryCondition plug = f.side[kZlo][1];
  plug.name = "plug", plug.shape.value = {0.004, 0.006, 0, 0.005};  // covers a quarter of it
  f.side[kZlo].push_back(plug);
  size = patch_sizes(f, kZlo, g)[1];
  EXPECT_NEAR(size.faces, 4e-5, 1e-18);
  EXPECT_NEAR(size.open, 3e-5, 1e-18);
  // A circle's drawn area; a region's nobody knows before it has been measured.
  PatchShape circle;
  circle.kind = PatchShape::Kind::kCircle;
  circle.value = {0.005, 0.005, 0.002, 0};
  EXPECT_NEAR(patch_sizes(fluid_with(circle), kZlo, g)[1].drawn, M_PI * 4e-6, 1e-18);
  PatchShape region;
  region.kind = PatchShape::Kind::kRegion;
  region.inside = [](const Vec3& x) { return x[0] < 0.003; };
  EXPECT_LT(patch_sizes(fluid_with(region), kZlo, g)[1].drawn, 0);
  EXPECT_NEAR(patch_sizes(fluid_with(region), kZlo, g)[1].faces, 3e-5, 1e-18);
  f = fluid_with(region);
  measure_regions(f, {0, 0.01, 0, 0.01, 0, 0.01});
  EXPECT_NEAR(patch_sizes(f, kZlo, g)[1].drawn, 3e-5, 1e-13);
}

TEST(Patches, RegionsHaveTheirExtentAndArea) {
  const std::array<double, 6> domain{0, 0.6, 0, 0.004, 0, 0.4};
  const auto ball = [](double x, double y, double r) {
    return [=](const Vec3& p) { return std::hypot(p[0] - x, p[1] - y, p[2]) < r; };
  };
  const auto measured = [&](const std::function<bool(const Vec3&)>& inside, std::vector<std::array<double, 6>> boxes) {
    PatchShape shape;
    shape.kind = PatchShape::Kind::kRegion;
    shape.inside = inside, shape.boxes = std::move(boxes);
    return measure_region(shape, kZlo, domain);
  };
  // A slit of 1.2 mm in 0.6 m with a box, and without one: less than one of 400 lines across.
  const auto slit = [](const Vec3& p) { return p[0] >= 0.3010 && p[0] <= 0.3022; };
  for (const auto& boxes : {std::vector<std::array<double, 6>>{{0.3010, 0.3022, -1e20, 1e20, -1e20, 1e20}}, {}}) {
    const RegionOutline o = measured(slit, boxes);
    ASSERT_TRUE(o.found);
    EXPECT_NEAR(o.extent[0], 0.3010, 1e-9);
    EXPECT_NEAR(o.extent[1], 0.3022, 1e-9);
    EXPECT_NEAR(o.extent[2], 0, 1e-12);
    EXPECT_NEAR(o.extent[3], 0.004, 1e-12);
    EXPECT_NEAR(o.area, 4.8e-6, 0.01 * 4.8e-6);
  }
  // A circle of 0.42 mm, and two of them far from each other.
  const double r = 0.21e-3, one = M_PI * r * r;
  const auto a = ball(0.0101, 0.0017, r), b = ball(0.5, 0.002, r);
  const std::array<double, 6> box_a{0.0101 - r, 0.0101 + r, 0.0017 - r, 0.0017 + r, -r, r};
  const std::array<double, 6> box_b{0.5 - r, 0.5 + r, 0.002 - r, 0.002 + r, -r, r};
  RegionOutline o = measured(a, {box_a});
  EXPECT_NEAR(o.area, one, 0.003 * one);
  EXPECT_NEAR(o.extent[1] - o.extent[0], 2 * r, 1e-3 * r);
  EXPECT_NEAR(o.extent[3] - o.extent[2], 2 * r, 1e-3 * r);
  o = measured([&](const Vec3& p) { return a(p) || b(p); }, {box_a, box_b});
  EXPECT_NEAR(o.area, 2 * one, 0.01 * 2 * one);
  EXPECT_NEAR(o.extent[0], 0.0101 - r, 1e-3 * r);
  EXPECT_NEAR(o.extent[1], 0.5 + r, 1e-3 * r);
  // The tip of a large ball: its box is the whole side.
  const auto tip = [](const Vec3& p) { return std::hypot(p[0] - 0.3, p[1] - 0.002, p[2] + 0.1) < 0.100005; };
  const double tip_r = std::sqrt(0.100005 * 0.100005 - 0.01);
  o = measured(tip, {{0.2, 0.4, -0.1, 0.1, -0.2, 5e-6}});
  EXPECT_NEAR(o.area, M_PI * tip_r * tip_r, 0.01 * M_PI * tip_r * tip_r);
  // None: beside the side, and nothing within the box.
  EXPECT_FALSE(measured(a, {{0, 1, 0, 1, 0.1, 0.2}}).found);
  EXPECT_FALSE(measured([](const Vec3&) { return false; }, {}).found);
}

TEST(Patches, ParabolicInletHasTheMeanVelocityGiven) {
  // 6 s (1 - s) at the centres of three cells has the mean 1.056, of a circle's cells another again.
  const FineGrid g = box_of(10, 0.01);
  PatchShape slot;
  slot.kind = PatchShape::Kind::kRectangle;
  slot.value = {0.004, 0.007, 0, 0.01};
  FluidSettings f = fluid_with(slot);
  f.side[kZlo][1].profile.shape = InletProfile::Shape::kParabolic;
  f.side[kZlo][1].profile.across = {true, false, false};
  EXPECT_NEAR(solved(f, g).area, 3e-5, 1e-18);
  EXPECT_NEAR(solved(f, g).flux, 3e-5, 1e-18);
  PatchShape circle;
  circle.kind = PatchShape::Kind::kCircle;
  circle.value = {0.0052, 0.0047, 0.0025, 0};
  f = fluid_with(circle);
  f.side[kZlo][1].profile.shape = InletProfile::Shape::kParabolic;
  EXPECT_NEAR(solved(f, g).flux, solved(f, g).area, 1e-18);
}

TEST(Patches, WarningOfAnAreaThatIsNotTheDrawn) {
  Settings s;
  s.domain = {0, 0.01, 0, 0.01, 0, 0.01};
  s.fine = {10, 10, 8};
  const auto warned = [&](const std::array<double, 4>& rect) {
    PatchShape slot;
    slot.kind = PatchShape::Kind::kRectangle;
    slot.value = rect;
    s.fluid = fluid_with(slot);
    const FineGrid g = fine_grid(s, {false, false, false});
    const auto w = scene_warnings(s, g, SceneFacts(), scene_numbers(s, g, SceneFacts()));
    const auto at =
        std::find_if(w.begin(), w.end(), [](const std::string& t) { return t.find("patch jet") != std::string::npos; });
    return at == w.end() ? std::string() : *at;
  };
  EXPECT_EQ(warned({0.002, 0.005, 0, 0.01}), "");      // on faces
  EXPECT_EQ(warned({0.00199, 0.00502, 0, 0.01}), "");  // 1 %
  EXPECT_NE(warned({0.0024, 0.0056, 0, 0.01}).find("+25 %"), std::string::npos);
  EXPECT_NE(warned({0.0026, 0.0054, 0, 0.01}).find("-28.57 %"), std::string::npos);
}

}  // namespace
}  // namespace twogrid
