// Surfaces of triangles, and exact signs.
// What would pass falsely without it: a line through an edge or a corner that slips between two triangles, or meets both; a
// distance that is only that of planes or corners.
#include <gtest/gtest.h>

#include <random>

#include "cfd/bodies/exact_turn.h"
#include "tests/unit/cfd/cut_scene.h"

namespace twogrid {
namespace {

std::vector<TriangleSet> each_of(const std::vector<Triangle>& list) {
  std::vector<TriangleSet> each;
  for (const Triangle& t : list) each.emplace_back(std::vector<Triangle>{t});
  return each;
}
/// How many of them a line along d from x crosses.
int crossings(const std::vector<TriangleSet>& each, const Vec3& x, int d, double length) {
  int n = 0;
  for (const TriangleSet& t : each) n += t.first_crossing(x, d, length) <= 1;
  return n;
}

}  // namespace

TEST(TriangleSet, ExactTurns) {
  // 2^-53 and its like decide; a rounded product says 0 or the wrong side.
  const double e = 0x1p-53;
  EXPECT_EQ(turn({0, 0}, {1 + 2 * e, 1 + 4 * e}, {1, 1 + 2 * e}), 1);
  EXPECT_EQ(turn({0.1, 0.1}, {0.3, 0.3}, {0.2, 0.2}), 0);
  EXPECT_EQ(turn({0.1, 0.1}, {0.7, 0.7}, {0.3, std::nextafter(0.3, 1.0)}), 1);
  EXPECT_EQ(turn({0.1, 0.1}, {0.7, 0.7}, {0.3, std::nextafter(0.3, 0.0)}), -1);
  EXPECT_EQ(turn({1e9 + 0.1, 0}, {1e9 + 0.3, 1e-9}, {1e9 + 0.1, 1e-300}), 1);
}

/// Lines along the axes through the corners, edges and middles of the faces of closed surfaces: as often in as out, and
/// from the inside out an odd number of times.
TEST(TriangleSet, EdgesAndCornersAreMetOnce) {
  std::vector<std::vector<Triangle>> bodies{box_mesh({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}),
                                            box_mesh({0.25, 0.3, 0.2}, {0.75, 0.75, 0.7}, true)};
  for (int d = 0; d < 3; ++d)
    for (int n : {3, 4, 7, 8, 64}) bodies.push_back(tube_mesh(d, {0.5, 0.5, 0.5}, 0.25, 0.2, 0.8, n, true));
  // An octahedron and, of twisted quads, one with many corners at round places.
  std::vector<Triangle> eight;
  for (int s = 0; s < 8; ++s)
    eight.push_back({Vec3{s & 1 ? 0.75 : 0.25, 0.5, 0.5}, Vec3{0.5, s & 2 ? 0.75 : 0.25, 0.5},
                     Vec3{0.5, 0.5, s & 4 ? 0.75 : 0.25}});
  bodies.push_back(eight);
  for (const auto& list : bodies) {
    const TriangleSet set(list);
    const std::vector<TriangleSet> each = each_of(list);
    std::vector<Vec3> through{{0.5, 0.5, 0.5}};
    for (const Triangle& t : list)
      for (int q = 0; q < 3; ++q) {
        through.push_back(t[q]);
        Vec3 middle;
        for (int d = 0; d < 3; ++d) middle[d] = 0.5 * (t[q][d] + t[(q + 1) % 3][d]);
        through.push_back(middle);
      }
    for (Vec3 x : through)
      for (int d = 0; d < 3; ++d) {
        x[d] = 0.013;
        EXPECT_EQ(crossings(each, x, d, 0.98) % 2, 0);
        Vec3 end = x;
        end[d] += 0.98;
        EXPECT_EQ(set.first_crossing(x, d, 0.98) <= 1, set.first_crossing(end, d, -0.98) <= 1);
        x[d] = 0.5003;
        const int up = crossings(each, x, d, 0.49), down = crossings(each, x, d, -0.49);
        EXPECT_EQ(up % 2, down % 2);
        EXPECT_EQ(up > 0, set.first_crossing(x, d, 0.49) <= 1);
        EXPECT_EQ(down > 0, set.first_crossing(x, d, -0.49) <= 1);
      }
    for (int d = 0; d < 3; ++d)
      for (double way : {-0.4, 0.4}) EXPECT_LE(set.first_crossing({0.5, 0.5, 0.5}, d, way), 1);
  }
}

/// With bins and without: the nearest point among all triangles, within reach; and crossings where the formula has them.
TEST(TriangleSet, DistancesAndCrossings) {
  const std::vector<Triangle> list = tube_mesh(1, {0.5, 0, 0.4}, 0.3, 0.1, 0.9, 90, false, 4);
  const TriangleSet set(list);
  const std::vector<TriangleSet> single = each_of(list);
  const CylinderShape round({0.5, 0, 0.4}, {0, 1, 0}, 0.3);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.2, 1.2);
  for (int q = 0; q < 300; ++q) {
    const Vec3 x{any(random), any(random), any(random)};
    Vec3 point{0, 0, 0}, best{0, 0, 0};
    double least = 1e300;
    for (const TriangleSet& s : single) {
      const double far = s.distance(x, 10, point);
      if (far < least) least = far, best = point;
    }
    EXPECT_NEAR(set.distance(x, 10, point), least, 1e-14);
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(point[d], best[d], 1e-7);
    EXPECT_NEAR(set.distance(x, least * 1.001, point), least, 1e-14);
    EXPECT_GE(set.distance(x, least * 0.999, point), least * 0.999);
    if (x[1] > 0.1 && x[1] < 0.9) {
      Vec3 foot;
      EXPECT_NEAR(least, round.distance(x, 10, foot), 0.3 * (1 - std::cos(kPi / 90)) + 1e-12);
    }
    for (int d : {0, 2}) {
      const double a = set.first_crossing(x, d, 0.37), b = round.first_crossing(x, d, 0.37);
      const Vec3 end{x[0] + (d == 0 ? 0.37 : 0), x[1], x[2] + (d == 2 ? 0.37 : 0)};
      const bool once = b < 1 && round.first_crossing(end, d, -0.37) + b > 0.999;
      if (x[1] > 0.1 && x[1] < 0.9 && once) {
        EXPECT_NEAR(a, b, 0.05);
      }
    }
  }
}

TEST(TriangleSet, BadMeshes) {
  EXPECT_THROW(TriangleSet({}), std::invalid_argument);
  EXPECT_THROW(TriangleSet({Triangle{Vec3{0, 0, 0}, Vec3{1, 1, 1}, Vec3{2, 2, 2}}}), std::invalid_argument);
  EXPECT_THROW(TriangleSet({Triangle{Vec3{0, 0, 0}, Vec3{1, NAN, 1}, Vec3{2, 0, 2}}}), std::invalid_argument);
}

}  // namespace twogrid
