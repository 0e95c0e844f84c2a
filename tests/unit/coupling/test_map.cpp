// The map between the two grids: mean over a node's faces, and its transpose.
//
// Without these tests would pass: a mean that is off where the grid is stretched or a wall takes part of a block's
// faces; a reaction that goes to other faces than were read, so that action and reaction only cancel on average; a body
// in the grid that reads or takes what the fluid beside it should.
#include <gtest/gtest.h>

#include <cmath>

#include "cfd/parallel/ranks.h"
#include "coupling/particles/ledger.h"
#include "coupling/two_grid/map.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

struct MapScene {
  FineGrid grid;
  Int3 ratio;
  std::unique_ptr<FakeFluid> fluid;
  std::unique_ptr<Map> map;
  MapScene(const Int3& ratio, std::array<bool, 3> periodic, double stretch)
      : grid(make_grid({0, 0, 0}, {1, 1, 2}, {8, 4, 16}, periodic, {stretch, 1, stretch})), ratio(ratio) {
    fluid = std::make_unique<FakeFluid>(MPI_COMM_WORLD, grid, make_layout(grid, ranks_of(MPI_COMM_WORLD), ratio));
  }
  void make() {
    ParticleGrid nodes(grid, ratio);
    nodes.take_open_part(MPI_COMM_WORLD, *fluid, {1, 1, 1});
    map = std::make_unique<Map>(MPI_COMM_WORLD, *fluid, nodes);
  }
  /// The mean's three components, read out of groups that hold something else beside them.
  NodeVector<CellField<ParticleGrid>> mean() const {
    const Box& own = map->own();
    std::vector<FourNumbers> groups(2 * own.count(), FourNumbers{{-7, -7, -7, -7}});
    const Slot<FourNumbers> slot{own, groups.data() + 1, 2};
    map->mean(fluid->u_, slot);
    NodeVector<CellField<ParticleGrid>> n;
    for (int d = 0; d < 3; ++d) {
      n[d].reset(own);
      for_each(own, [&](int i, int j, int k) { n[d](i, j, k) = slot.data[2 * slot.index(i, j, k)].at[d]; });
    }
    for (std::size_t m = 0; m < groups.size(); m += 2) EXPECT_EQ(groups[m].at[0], -7);
    return n;
  }
  struct Spread {
    FaceField<FineGrid> source, beta;
    Vec3 held_back;
  };
  /// q: whole numbers.
  template <class Q>
  Spread spread(const std::array<FixedPoint, 2>& scale, Q q) const {
    const Box& own = map->own();
    std::vector<FourWholeNumbers> groups(own.count());
    const Slot<FourWholeNumbers> slot{own, groups.data(), 1};
    for_each(own, [&](int i, int j, int k) { groups[slot.index(i, j, k)] = q(i, j, k); });
    NodeSpread source, beta;
    Spread made;
    made.held_back = map->spread(slot, scale, source, beta);
    for (int d = 0; d < 3; ++d) source.field(d, made.source[d]), beta.field(d, made.beta[d]);
    return made;
  }
};

double total(double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

TEST(Map, RatioThatDoesNotDivideIsRefused) {
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {10, 10, 10}, {false, false, false});
  try {
    ParticleGrid nodes(grid, {5, 4, 2});
    FAIL() << "a ratio of 4 in 10 cells was taken";
  } catch (const std::invalid_argument& e) {
    EXPECT_EQ(std::string(e.what()), "ratio 4 does not divide the 10 fine cells in direction y: change ratio or fine");
  }
}

TEST(Map, UniformVelocityIsExactAndLinearVelocityIsExactOnUniformGrids) {
  for (double stretch : {1.0, 1.1})
    for (Int3 ratio : {Int3{1, 1, 1}, Int3{2, 2, 4}, Int3{4, 1, 2}}) {
      MapScene s(ratio, {true, true, true}, stretch);
      s.make();
      s.fluid->set(s.fluid->u_, [](int d, const Vec3&) { return 1.25 + d; });
      auto n = s.mean();
      for (int d = 0; d < 3; ++d)
        for_each(s.map->own(), [&](int i, int j, int k) { EXPECT_NEAR(n[d](i, j, k), 1.25 + d, 1e-15 * 4); });
      if (stretch != 1) continue;
      auto profile = [](int d, const Vec3& x) { return 0.3 + d + 0.5 * x[0] - 0.7 * x[1] + 0.2 * x[2]; };
      s.fluid->set(s.fluid->u_, profile);
      n = s.mean();
      for (int d = 0; d < 3; ++d)
        for_each(s.map->own(), [&](int i, int j, int k) {
          const Axis* a = s.map->grid().axis.data();
          EXPECT_NEAR(n[d](i, j, k), profile(d, {a[0].centre(i), a[1].centre(j), a[2].centre(k)}), 1e-14);
        });
    }
}

// Walls have weight zero and the rest is scaled up; a node with walls only reads 0 and hands its share to the wall.
TEST(Map, WallsHaveNoWeight) {
  MapScene s({2, 4, 2}, {false, false, false}, 1.0);
  // One node deep in y, with all its y faces fixed: a scene that has no y velocity.
  for_each(s.fluid->state_[1].box(), [&](int i, int j, int k) { s.fluid->state_[1](i, j, k) = FaceState::kFixed; });
  s.make();
  s.fluid->set(s.fluid->u_, [](int, const Vec3&) { return 2.0; });
  for (int d = 0; d < 3; ++d)
    for_each(s.fluid->u_[d].box(), [&](int i, int j, int k) {
      if (s.fluid->state_[d](i, j, k) == FaceState::kFixed) s.fluid->u_[d](i, j, k) = 77;
    });
  const auto n = s.mean();
  for_each(s.map->own(), [&](int i, int j, int k) {
    EXPECT_NEAR(n[0](i, j, k), 2, 1e-15);
    EXPECT_EQ(n[1](i, j, k), 0);
    EXPECT_NEAR(n[2](i, j, k), 2, 1e-15);
  });
  const std::array<FixedPoint, 2> scale{FixedPoint(64.0, 1), FixedPoint(1.0, 1)};
  double sum = 0;
  const auto made = s.spread(scale, [&](int i, int j, int k) {
    const double q = 1 + i + 10 * j + 0.125 * k;
    sum += q;
    const long long whole = scale[0].quantise(q);
    return FourWholeNumbers{{whole, whole, whole, scale[1].quantise(0.5)}};
  });
  EXPECT_EQ(made.held_back[0], 0);
  EXPECT_NEAR(total(made.held_back[1]), total(sum), 1e-12 * total(sum));
  for (const Array3<double>* y : {&made.source[1], &made.beta[1]})
    for (std::size_t m = 0; m < y->size(); ++m) EXPECT_EQ(y->data()[m], 0);
}

TEST(Map, SpreadIsTheTransposeOfMean) {
  for (bool body : {false, true})
    for (double stretch : {1.0, 1.1})
      for (Int3 ratio : {Int3{1, 1, 1}, Int3{2, 2, 4}, Int3{8, 4, 2}})
        for (int sides = 0; sides < 3; ++sides) {
          MapScene s(ratio, {sides == 1, sides == 1, sides >= 1}, stretch);
          if (sides == 0) s.fluid->open_side(2, true);  // an outlet is solved for
          if (body) cut_corner(*s.fluid);
          s.make();
          // Values from the position alone, so that all ranks agree on those they share. Periodic in z where z is.
          s.fluid->set(s.fluid->u_, [](int d, const Vec3& x) {
            return std::sin(2 * M_PI * x[0] + d) + std::cos(2 * M_PI * x[1]) + std::sin(M_PI * x[2] + 0.3);
          });
          const auto n = s.mean();
          Sum left, right, given, received, given_beta, received_beta;
          const std::array<FixedPoint, 2> scale{FixedPoint(1.0, 100), FixedPoint(2.0, 1)};
          const auto made = s.spread(scale, [&](int i, int j, int k) {
            FourWholeNumbers whole;
            for (int c = 0; c < 4; ++c) {
              const FixedPoint& unit = scale[c < 3 ? 0 : 1];
              whole.at[c] = unit.quantise(std::sin(1.0 + 3 * i + 5 * j + 7 * k + 11 * c) + (c == 3));
              const double q = unit.value(whole.at[c]);
              if (c < 3) left += q * n[c](i, j, k);
              if (c < 3) given += q;
              for (int d = 0; c == 3 && d < 3; ++d)
                if (n[d](i, j, k) != 0) given_beta += q;  // else no face takes it: inside the body
            }
            return whole;
          });
          for (int d = 0; d < 3; ++d) {
            received += made.held_back[d];
            for_each(s.map->faces(d), [&](int i, int j, int k) {
              const double v = s.map->face_volume(d, i, j, k), f = made.source[d](i, j, k) * v;
              received_beta += made.beta[d](i, j, k) * v;
              if (f == 0) return;
              right += f * s.fluid->u_[d](i, j, k);
              received += f;
            });
            const Box& b = s.map->faces(d);
            double by_rows = 0, by_faces = 0;
            for (int k = b.lo[2]; k < b.hi[2]; ++k)
              for (int j = b.lo[1]; j < b.hi[1]; ++j)
                by_rows += s.map->integral(d, j, k, &made.source[d].data()[made.source[d].index(b.lo[0], j, k)]);
            for_each(
                b, [&](int i, int j, int k) { by_faces += made.source[d](i, j, k) * s.map->face_volume(d, i, j, k); });
            EXPECT_NEAR(by_rows, by_faces, 1e-12);
          }
          EXPECT_NEAR(total(given_beta.value()), total(received_beta.value()), 1e-11);
          EXPECT_NEAR(total(left.value()), total(right.value()), 1e-12);
          EXPECT_NEAR(total(given.value()), total(received.value()), 1e-12);
        }
}

// Shares that are all 1 change nothing but rounding; weights are those of the halves, each with its cell's theta.
TEST(Map, OpenSharesWeighHalves) {
  for (Int3 ratio : {Int3{1, 1, 1}, Int3{2, 2, 4}, Int3{4, 1, 2}}) {
    std::vector<double> found[2];
    for (bool open : {false, true}) {
      MapScene s(ratio, {false, true, false}, 1.1);
      if (open) s.fluid->cut([](int, const Vec3&) { return 1.0; }, [](const Vec3&) { return 1.0; });
      s.make();
      s.fluid->set(s.fluid->u_, [](int d, const Vec3& x) { return std::sin(6 * x[0] + d) + x[2] * x[2]; });
      const auto n = s.mean();
      const std::array<FixedPoint, 2> scale{FixedPoint(8.0, 1), FixedPoint(8.0, 1)};
      const auto made = s.spread(scale, [&](int i, int j, int k) {
        const long long q = scale[0].quantise(std::sin(1.0 + 3 * i + 5 * j + 7 * k));
        return FourWholeNumbers{{q, q, q, q}};
      });
      for (int d = 0; d < 3; ++d) {
        for_each(s.map->own(), [&](int i, int j, int k) { found[open].push_back(n[d](i, j, k)); });
        for (const Array3<double>* f : {&made.source[d], &made.beta[d]})
          found[open].insert(found[open].end(), f->data(), f->data() + f->size());
      }
    }
    ASSERT_EQ(found[0].size(), found[1].size());
    for (std::size_t m = 0; m < found[0].size(); ++m)
      EXPECT_NEAR(found[0][m], found[1][m], 1e-13 * std::max(1.0, std::abs(found[0][m])));

    MapScene s(ratio, {false, true, false}, 1.1);
    cut_corner(*s.fluid);
    s.make();
    s.fluid->set(s.fluid->u_, [](int d, const Vec3&) { return 3.0 + d; });
    const auto n = s.mean();
    const CellField<FineGrid>& theta = s.fluid->open_->theta();
    for (int d = 0; d < 3; ++d)
      for_each(s.map->own(), [&](int I, int J, int K) {
        double weight = 0;
        for_each(s.map->grid().block(I, J, K), [&](int i, int j, int k) { weight += theta(i, j, k); });
        if (weight == 0) {
          EXPECT_EQ(n[d](I, J, K), 0);
        }
        if (n[d](I, J, K) != 0) {
          EXPECT_NEAR(n[d](I, J, K), 3.0 + d, 1e-14);
        }
      });
  }
}

}  // namespace
}  // namespace twogrid_test
