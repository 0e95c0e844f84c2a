#include "coupling/two_grid/fluid_layout.h"

#include <algorithm>

namespace twogrid {

double layout_cost(const Grid& grid, const Int3& ratio, const Layout& layout, const std::vector<Box>& window) {
  double most = 0;
  for (int r = 0; r < layout.ranks(); ++r) {
    const Box own = layout.cells(r);
    const double cells = double(own.count());
    double cost = cells > 0 ? cells * (1 + LayoutCost::kRow / own.size(0)) : 0.0;
    for (int d = 0; d < 3 && cells > 0; ++d)
      for (bool open :
           {own.lo[d] > 0 || (grid.axis[d].periodic() && own.size(d) < layout.extent()[d]),
            own.hi[d] < layout.extent()[d] || (grid.axis[d].periodic() && own.size(d) < layout.extent()[d])})
        if (open) cost += LayoutCost::kPeer + LayoutCost::kHalo * cells / own.size(d);
    Box nodes = own;
    for (int d = 0; d < 3; ++d) nodes.lo[d] /= ratio[d], nodes.hi[d] /= ratio[d];
    cost += LayoutCost::kMoved * double(window[r].count() - intersect(window[r], nodes).count());
    most = std::max(most, cost);
  }
  return most;
}

Layout equal_bricks(const Grid& grid, const Int3& ratio, const Int3& bricks) {
  std::array<std::vector<int>, 3> cuts;
  for (int d = 0; d < 3; ++d) cuts[d] = cuts_even(grid.axis[d], bricks[d], ratio[d]);
  return Layout(grid, cuts);
}

Layout choose_fluid_layout(const Grid& grid, const Int3& ratio, const Layout& follow, const std::vector<Box>& window) {
  const int ranks = follow.ranks();
  if (ranks == 1) return follow;
  Layout best = follow;
  double least = layout_cost(grid, ratio, follow, window) / 1.1;
  for (int pz = 1; pz <= ranks; ++pz)
    for (int py = 1; ranks % pz == 0 && py <= ranks / pz; ++py) {
      if ((ranks / pz) % py) continue;
      const Int3 bricks{ranks / pz / py, py, pz};
      bool fits = true;
      for (int d = 0; d < 3; ++d) fits = fits && bricks[d] <= grid.n()[d] / ratio[d];
      if (!fits) continue;
      const Layout layout = equal_bricks(grid, ratio, bricks);
      const double cost = layout_cost(grid, ratio, layout, window);
      if (cost < least) least = cost, best = layout;
    }
  return best;
}

}  // namespace twogrid
