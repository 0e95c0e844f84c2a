// The fluid's own bricks.
//
// Without these tests would pass: bricks that cut a particle cell in two; a thin bed cut across its rows, so that most
// of the work is in the beginnings of rows; a large cubic problem taken away from its particles for nothing; ranks left
// without cells because the fluid fills only a part of LIGGGHTS' box.
#include <gtest/gtest.h>

#include "coupling/two_grid/fluid_layout.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

Int3 bricks_of(const Layout& layout) {
  Int3 p;
  for (int d = 0; d < 3; ++d) p[d] = int(layout.cuts()[d].size()) - 1;
  return p;
}

/// Chosen for particles that lie in `bricks` equal parts of the box from 0 to `box` (in the fluid's lengths).
Layout chosen(const FineGrid& grid, const Int3& ratio, const Int3& bricks, const Vec3& box = {1, 1, 1}) {
  const ParticleGrid nodes(grid, ratio);
  std::array<std::vector<int>, 3> cuts;
  std::vector<Box> window;
  std::array<std::vector<double>, 3> border;
  for (int d = 0; d < 3; ++d) {
    for (int i = 0; i <= bricks[d]; ++i) border[d].push_back(box[d] * grid.axis[d].hi() * i / bricks[d]);
    cuts[d] = cuts_near(grid.axis[d], bricks[d], ratio[d], {border[d].begin() + 1, border[d].end() - 1});
  }
  for (int k = 0; k < bricks[2]; ++k)
    for (int j = 0; j < bricks[1]; ++j)
      for (int i = 0; i < bricks[0]; ++i) {
        const Int3 b{i, j, k};
        Box w;
        for (int d = 0; d < 3; ++d) {
          w.lo[d] = std::max(nodes.axis[d].find(border[d][b[d]]) - 1, 0);
          w.hi[d] = std::min(nodes.axis[d].find(border[d][b[d] + 1]) + 2, nodes.axis[d].n());
        }
        window.push_back(w);
      }
  const Layout follow(grid, cuts);
  const Layout layout = choose_fluid_layout(grid, ratio, follow, window);
  EXPECT_LE(layout_cost(grid, ratio, layout, window), layout_cost(grid, ratio, follow, window));
  for (int d = 0; d < 3; ++d)
    for (int c : layout.cuts()[d]) EXPECT_EQ(c % ratio[d], 0);
  return layout;
}

const std::array<bool, 3> kClosed{false, false, false};

TEST(FluidLayout, LowBedIsCutAcrossItsHeight) {
  const FineGrid grid = make_grid({0, 0, 0}, {0.044, 0.010, 0.150}, {15, 3, 50}, kClosed);
  EXPECT_EQ(bricks_of(chosen(grid, {1, 1, 1}, {2, 1, 1})), (Int3{1, 1, 2}));
  EXPECT_EQ(bricks_of(chosen(grid, {1, 1, 1}, {4, 2, 1})), (Int3{1, 1, 8}));
}

TEST(FluidLayout, LargeCubeStaysWithItsParticles) {
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {128, 128, 128}, kClosed);
  EXPECT_EQ(bricks_of(chosen(grid, {1, 1, 1}, {2, 2, 2})), (Int3{2, 2, 2}));
}

TEST(FluidLayout, EveryRankHasCells) {
  // The fluid fills the lower half of the box.
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {32, 32, 32}, kClosed);
  const Layout layout = chosen(grid, {2, 2, 2}, {1, 1, 4}, {1, 1, 2});
  for (int r = 0; r < 4; ++r) EXPECT_EQ(layout.cells(r).count(), 32u * 32 * 32 / 4);
}

TEST(FluidLayout, FewerParticleCellsThanRanks) {
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {4, 4, 4}, kClosed);
  const Layout layout = chosen(grid, {4, 4, 4}, {2, 1, 1});
  EXPECT_EQ(layout.cells(0).count() + layout.cells(1).count(), 64u);
}

}  // namespace
}  // namespace twogrid_test
