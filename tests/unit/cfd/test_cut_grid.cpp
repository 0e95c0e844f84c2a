// Bodies in the fluid's grid: what they cut against formulas, turned, mirrored and on any ranks.
// What would pass falsely without it: a cut area or volume that is nearly right; a cylinder that is another one along
// another axis, mirrored, or on other ranks; a wall in a plane of the grid that leaks, or closes the cells beside it.
#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "tests/unit/cfd/cut_scene.h"

namespace twogrid {

/// A pipe's section and a ball's volume: second order, with the known figure of chords at 13 cells a diameter.
TEST(CutGrid, CirclesAndBallsAreOfSecondOrder) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, 1);
  double section[2] = {0, 0}, ball[2] = {0, 0}, wall[2] = {0, 0};
  const int cells[2] = {16, 32}, tries = 12;
  for (int fine = 0; fine < 2; ++fine)
    for (int q = 0; q < tries; ++q) {
      const double R = 6.5 / 16, h = 1.0 / cells[fine];
      const Vec3 centre{0.5 + h * (any(random) - 0.5), 0.5 + h * (any(random) - 0.5), 0.5 + h * (any(random) - 0.5)};
      const int d = q % 3;
      Vec3 axis{0, 0, 0};
      axis[d] = 1;
      std::array<bool, 3> periodic{false, false, false};
      periodic[d] = true;
      Int3 n{cells[fine], cells[fine], cells[fine]};
      n[d] = 4;
      const FluidIs side = q % 2 ? FluidIs::kInside : FluidIs::kOutside;
      CutScene pipe(nodes_of(n), periodic, {body_of<CylinderShape>(centre, axis, R, side)});
      pipe.run();
      const double area = pipe.open_area(d, 2), inside = side == FluidIs::kInside ? area : 1 - area;
      section[fine] += (inside / (kPi * R * R) - 1) / tries;
      wall[fine] += (pipe.report.bodies[0].area / (2 * kPi * R) - 1) / tries;
      EXPECT_NEAR(pipe.report.bodies[0].volume + pipe.report.open_volume, 1, 1e-12);
      EXPECT_NEAR(pipe.report.open_volume, area, 1e-4);
      CutScene drop(nodes_of({cells[fine], cells[fine], cells[fine]}), {false, false, false},
                    {body_of<SphereShape>(centre, R, side)});
      drop.run();
      const double V = side == FluidIs::kInside ? drop.report.open_volume : 1 - drop.report.open_volume;
      ball[fine] += (V / (4 * kPi / 3 * R * R * R) - 1) / tries;
      for (int e = 0; e < 3; ++e) {
        double sum = 0;
        for (double a : drop.wall(e)) sum += a;
        EXPECT_NEAR(sum, 0, 1e-13);
      }
    }
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("section %.4f %.4f, wall %.4f %.4f, ball %.4f %.4f\n", section[0], section[1], wall[0], wall[1],
                ball[0], ball[1]);
  EXPECT_NEAR(section[0], -0.005, 0.0015);
  EXPECT_GT(section[0] / section[1], 3.3);
  EXPECT_NEAR(ball[0], -0.0115, 0.003);
  EXPECT_GT(ball[0] / ball[1], 3.3);
  EXPECT_LT(std::abs(wall[0]), 0.005);
  EXPECT_LT(std::abs(wall[1]), 0.0015);
}

/// An oblique cylinder and a ball, in x, y, z turned and mirrored: the same numbers at the places turned and mirrored.
TEST(CutGrid, TurnedAndMirroredAreTheSame) {
  const Int3 n{12, 13, 11};
  const Vec3 size{1.2, 1.3, 1.1}, point{0.61, 0.58, 0.55}, axis{0.3, 0.5, 0.8}, centre{0.21, 1.02, 0.3};
  const auto scene = [&](const std::array<int, 3>& to, const std::array<bool, 3>& mirrored) {
    const auto turned = [&](const Vec3& x, bool place) {
      Vec3 y;
      for (int d = 0; d < 3; ++d) y[to[d]] = mirrored[d] ? (place ? size[d] - x[d] : -x[d]) : x[d];
      return y;
    };
    Int3 m;
    Vec3 hi;
    for (int d = 0; d < 3; ++d) m[to[d]] = n[d], hi[to[d]] = size[d];
    CutScene s(nodes_of(m, {0, 0, 0}, hi), {false, false, false},
               {body_of<CylinderShape>(turned(point, true), turned(axis, false), 0.3013, FluidIs::kOutside),
                body_of<SphereShape>(turned(centre, true), 0.1517, FluidIs::kOutside)});
    s.run();
    return s;
  };
  const CutScene first = scene({0, 1, 2}, {false, false, false});
  const std::vector<double> theta = first.theta();
  std::array<std::vector<double>, 3> alpha, friction, links;
  for (int d = 0; d < 3; ++d) alpha[d] = first.alpha(d), friction[d] = first.conductance(d), links[d] = first.links(d);
  for (const std::array<int, 3>& to : {std::array<int, 3>{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}})
    for (int m = 0; m < 8; m += to[0] == 0 ? 1 : 3) {
      const std::array<bool, 3> mirrored{(m & 1) != 0, (m & 2) != 0, (m & 4) != 0};
      const CutScene other = scene(to, mirrored);
      const auto place = [&](const Int3& x, int normal) {
        Int3 y;
        for (int d = 0; d < 3; ++d) y[to[d]] = mirrored[d] ? n[d] - x[d] - (d == normal ? 0 : 1) : x[d];
        return other.at(y);
      };
      double apart = 0;
      long long differ = 0;
      const std::vector<double> t = other.theta();
      for_each(first.grid.cells(), [&](int i, int j, int k) {
        apart = std::max(apart, std::abs(theta[first.at({i, j, k})] - t[place({i, j, k}, -1)]));
      });
      for (int d = 0; d < 3; ++d) {
        const std::vector<double> a = other.alpha(to[d]), f = other.conductance(to[d]), l = other.links(to[d]);
        Box all = first.grid.cells();
        ++all.hi[d];
        for_each(all, [&](int i, int j, int k) {
          const std::size_t x = first.at({i, j, k}), y = place({i, j, k}, d);
          apart = std::max(apart, std::abs(alpha[d][x] - a[y]));
          apart = std::max(apart, std::abs(friction[d][x] - f[y]) / (0.01 + friction[d][x]));
          unsigned bits = unsigned(links[d][x]) & OpenSpace::kSliver;
          for (int e = 0; e < 3; ++e)
            for (int up = 0; up < 2; ++up)
              if (unsigned(links[d][x]) >> (2 * e + up) & 1) bits |= 1u << (2 * to[e] + (mirrored[e] ? 1 - up : up));
          differ += bits != unsigned(l[y]);
        });
      }
      EXPECT_LT(apart, 1e-10) << to[0] << to[1] << to[2] << " " << m;
      EXPECT_EQ(differ, 0) << to[0] << to[1] << to[2] << " " << m;
    }
}

namespace {

/// All that the cutting gives, of all ranks.
std::vector<double> everything(const CutScene& s) {
  std::vector<double> all = s.theta();
  for (int d = 0; d < 3; ++d)
    for (const auto& list : {s.alpha(d), s.links(d), s.conductance(d), s.wall(d)})
      all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace

/// The same bits on all ranks together as on each alone, with bodies over periodic sides, meshes, labels and pockets.
TEST(CutGrid, SameBitsOnAnyNumberOfRanks) {
  const std::array<std::vector<double>, 3> nodes{graded_nodes(0, 1, 17), graded_nodes(0, 1.1, 18, 1.04),
                                                 graded_nodes(0, 0.9, 16)};
  const std::vector<Body> bodies{
      body_of<CylinderShape>(Vec3{0.5, 0.5, 0.4}, Vec3{0.2, 1, 0.3}, 0.2113, FluidIs::kOutside),
      body_of<SphereShape>(Vec3{0.02, 0.3, 0.83}, 0.1517), mesh(box_mesh({0.7, 0.6, 0.2}, {0.93, 0.9, 0.61})),
      mesh(tube_mesh(1, {0.2, 0, 0.25}, 0.13, 0, 1.1, 37))};
  for (const std::array<bool, 3>& periodic : {std::array<bool, 3>{true, false, true}, {true, false, false}}) {
    std::vector<double> list[2];
    for (int alone = 0; alone < 2; ++alone) {
      CutScene s(nodes, periodic, bodies, alone ? MPI_COMM_SELF : MPI_COMM_WORLD);
      s.fluid_at({0.75, 0.05, 0.7});
      s.run();
      list[alone] = everything(s);
    }
    ASSERT_EQ(list[0].size(), list[1].size());
    long long differ = 0;
    for (std::size_t m = 0; m < list[0].size(); ++m) differ += list[0][m] != list[1][m];
    EXPECT_EQ(differ, 0);
  }
}

/// A ball over a periodic side's edge is as large as one inside, and bits of links fit over the side.
TEST(CutGrid, PeriodicSidesAreNone) {
  double volume[2];
  for (int shifted = 0; shifted < 2; ++shifted) {
    const Vec3 centre = shifted ? Vec3{0.013, 0.5 + 0.013, 1.0 + 0.013} : Vec3{0.5 + 0.013, 0.5 + 0.013, 0.5 + 0.013};
    CutScene s(nodes_of({16, 16, 16}), {true, true, true}, {body_of<SphereShape>(centre, 0.3, FluidIs::kOutside)});
    s.run();
    volume[shifted] = s.report.open_volume;
    for (int c = 0; c < 3; ++c) {
      const std::vector<double> bits = s.links(c), a = s.alpha(c);
      for_each(s.grid.cells(), [&](int i, int j, int k) {
        for (int d = 0; d < 3; ++d) {
          Int3 next{i, j, k};
          next[d] = (next[d] + 1) % 16;
          EXPECT_EQ(unsigned(bits[s.at({i, j, k})]) >> (2 * d + 1) & 1, unsigned(bits[s.at(next)]) >> (2 * d) & 1);
        }
      });
    }
  }
  EXPECT_NEAR(volume[0], volume[1], 1e-12);
}

/// A box of triangles along the grid's planes, the fluid around it or inside: whole cells and faces, nothing else.
TEST(CutGrid, AlignedBoxesAreWholeCells) {
  for (bool inside : {false, true})
    for (double off : {0.0, 3e-6, -3e-6}) {
      CutScene s(nodes_of({10, 10, 10}), {false, false, false},
                 {mesh(box_mesh({0.3 + off, 0.2 - off, 0.4 + off}, {0.7 - off, 0.8 + off, 0.6 + off}, true))});
      s.fluid_at(inside ? Vec3{0.5, 0.5, 0.5} : Vec3{0.1, 0.1, 0.1});
      s.run();
      const auto in = [&](int i, int j, int k) {
        return (i >= 3 && i < 7 && j >= 2 && j < 8 && k >= 4 && k < 6) == inside;
      };
      for_each(s.own(), [&](int i, int j, int k) { EXPECT_NEAR(s.space.theta(i, j, k), in(i, j, k), 1e-12); });
      for (int d = 0; d < 3; ++d)
        for_each(s.faces(d), [&](int i, int j, int k) {
          Int3 below{i, j, k}, above{i, j, k};
          --below[d];
          if (below[d] < 0) below = above;
          if (above[d] > 9) above = below;
          EXPECT_NEAR(s.space.alpha[d](i, j, k), in(below[0], below[1], below[2]) && in(above[0], above[1], above[2]),
                      1e-4)
              << d << " " << i << " " << j << " " << k << " " << inside;
        });
      EXPECT_NEAR(s.report.bodies[0].volume, inside ? 1 - 0.048 : 0.048, 1e-12);
    }
}

/// A vessel that touches the sides, its wall a formula or triangles, closed in the sides' planes or not.
TEST(CutGrid, AVesselThatTouchesTheSides) {
  const double R = 0.5;
  std::vector<double> theta[4];
  double area[4];
  for (int q = 0; q < 4; ++q) {
    Body wall = q == 0   ? body_of<CylinderShape>(Vec3{0.5, 0.5, 0}, Vec3{0, 0, 1}, R, FluidIs::kInside)
                : q == 1 ? body_of<CylinderShape>(Vec3{0.5, 0.5, 0}, Vec3{0, 0, 1}, R)
                         : mesh(tube_mesh(2, {0.5, 0.5, 0}, R, 0, 0.7, 512, q == 3));
    CutScene s(nodes_of({20, 20, 14}, {0, 0, 0}, {1, 1, 0.7}), {false, false, false}, {wall});
    s.side(kZlo, BoundaryKind::kInlet).side(kZhi, BoundaryKind::kPressure);
    if (q > 0) s.fluid_at({0.5, 0.5, 0.35});
    s.run();
    area[q] = s.open_area(2, 0);
    theta[q] = s.theta();
    EXPECT_NEAR(area[q] / (kPi * R * R), 1, 0.004) << q;
    EXPECT_NEAR(s.open_area(2, 7), area[q], 2e-4) << q;
    EXPECT_NEAR(s.report.open_volume, area[q] * 0.7, 2e-4) << q;
    EXPECT_NEAR(s.report.narrowest, 19.5, 0.6) << q;  // off the middle a little less
    for (double layer : s.report.open_layers[2]) EXPECT_NEAR(layer, area[q] * 0.05, 2e-5) << q;
  }
  for (int q = 1; q < 4; ++q)
    for (std::size_t m = 0; m < theta[0].size(); ++m) ASSERT_NEAR(theta[q][m], theta[0][m], q == 1 ? 1e-12 : 3e-3) << q;
}

/// A tube of triangles is the tube of the formula but for its facets: chords of a circle.
TEST(CutGrid, TrianglesAreTheFormulaButForFacets) {
  for (int facets : {48, 192}) {
    const Vec3 centre{0.487, 0, 0.512};
    CutScene round(nodes_of({16, 8, 16}), {false, true, false},
                   {body_of<CylinderShape>(centre, Vec3{0, 1, 0}, 0.4, FluidIs::kInside)});
    CutScene faceted(nodes_of({16, 8, 16}), {false, true, false}, {mesh(tube_mesh(1, centre, 0.4, 0, 1, facets))});
    faceted.fluid_at({0.5, 0.5, 0.5});
    round.run(), faceted.run();
    const double depth = 0.4 * (1 - std::cos(kPi / facets)) * 16;  // of the facets, in cells
    double worst = 0;
    const std::vector<double> a = round.theta(), b = faceted.theta();
    for (std::size_t m = 0; m < a.size(); ++m) worst = std::max(worst, std::abs(a[m] - b[m]));
    EXPECT_LT(worst, 2 * depth);
    EXPECT_NEAR(round.report.open_volume, faceted.report.open_volume, 2 * kPi * 0.4 * depth / 16);
    EXPECT_EQ(round.report.closed_cells > 0, true);
  }
}

/// One cell deep, closed or periodic: a cylinder across it.
TEST(CutGrid, OneCellDeep) {
  for (bool periodic : {false, true})
    for (int d = 0; d < 3; ++d) {
      Vec3 axis{0, 0, 0}, hi{1, 1, 1};
      Int3 n{16, 16, 16};
      std::array<bool, 3> around{false, false, false};
      axis[d] = 1, n[d] = 1, hi[d] = 0.1, around[d] = periodic;
      CutScene s(nodes_of(n, {0, 0, 0}, hi), around,
                 {body_of<CylinderShape>(Vec3{0.51, 0.52, 0.53}, axis, 0.3, FluidIs::kOutside)});
      s.run();
      EXPECT_NEAR(s.report.open_volume, 0.1 * (1 - kPi * 0.09), 0.0003);
      EXPECT_NEAR(s.report.bodies[0].area, 0.1 * 2 * kPi * 0.3, 0.002);
    }
}

/// Whatever the radius and the place: no leak, areas right.
TEST(CutGrid, RandomRadiiAndOffsets) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(0, 1);
  for (int q = 0; q < 60; ++q) {
    const double R = 0.15 + 0.3 * any(random);
    const Vec3 centre{0.5 + 0.04 * (any(random) - 0.5), 0.5 + 0.04 * (any(random) - 0.5), 0.5};
    const Vec3 axis{0.3 * (any(random) - 0.5), 0.3 * (any(random) - 0.5), 1};
    const double tilt = std::sqrt(1 + axis[0] * axis[0] + axis[1] * axis[1]);
    const bool triangles = q % 2;
    CutScene s(nodes_of({20, 20, 6}, {0, 0, 0.35}, {1, 1, 0.65}), {false, false, false},
               {body_of<CylinderShape>(centre, axis, R)});
    if (triangles) {
      std::vector<Triangle> list = tube_mesh(2, {0, 0, 0}, R, 0.3, 0.7, 97);
      for (Triangle& t : list)
        for (Vec3& v : t) {
          // Sheared, not turned: the section across z is a circle.
          for (int d = 0; d < 2; ++d) v[d] += centre[d] + axis[d] * (v[2] - 0.5);
        }
      s.settings.bodies = {mesh(list)};
    }
    s.fluid_at({0.5, 0.5, 0.5});
    s.run();
    const double wanted = kPi * R * R * (triangles ? 1 : tilt);
    for (int plane = 0; plane <= 6; ++plane)
      EXPECT_NEAR(s.open_area(2, plane) / wanted, 1, 0.0009 / (R * R)) << R << " " << plane << " " << triangles;
  }
}

TEST(CutGrid, MillionCellsInSeconds) {
  if (ranks_of(MPI_COMM_WORLD) > 1) return;
  for (bool triangles : {false, true}) {
    CutScene s(nodes_of({100, 100, 100}), {false, false, false},
               {triangles ? mesh(tube_mesh(2, {0.5, 0.5, 0}, 0.47, 0, 1, 250, false, 40))
                          : body_of<CylinderShape>(Vec3{0.5, 0.5, 0}, Vec3{0, 0, 1}, 0.47)});
    s.fluid_at({0.5, 0.5, 0.5});
    const auto begin = std::chrono::steady_clock::now();
    s.run();
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("10^6 cells, %s: %.2f s\n", triangles ? "20000 triangles" : "a formula", took);
    EXPECT_LT(took, 20);  // 2 and 3 s where nothing else runs
  }
}

}  // namespace twogrid
