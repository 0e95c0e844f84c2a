#include "cfd/grid/layout.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace twogrid {

Layout::Layout(const Grid& grid, std::array<std::vector<int>, 3> cuts, std::vector<Int3> brick_of_rank)
    : n_(grid.n()), periodic_(grid.periodic()), cuts_(std::move(cuts)), bricks_(std::move(brick_of_rank)) {
  Int3 p;
  for (int d = 0; d < 3; ++d) {
    p[d] = int(cuts_[d].size()) - 1;
    if (p[d] < 1 || cuts_[d].front() != 0 || cuts_[d].back() != n_[d])
      throw std::invalid_argument("the cuts of a layout must go from 0 to the number of cells, " +
                                  std::to_string(n_[d]));
    for (int a = 0; a < p[d]; ++a)
      if (cuts_[d][a + 1] < cuts_[d][a]) throw std::invalid_argument("the cuts of a layout must ascend");
  }
  if (bricks_.empty())
    for (int c = 0; c < p[2]; ++c)
      for (int b = 0; b < p[1]; ++b)
        for (int a = 0; a < p[0]; ++a) bricks_.push_back({a, b, c});
  if (int(bricks_.size()) != p[0] * p[1] * p[2])
    throw std::invalid_argument("a layout of " + std::to_string(p[0] * p[1] * p[2]) + " bricks was given " +
                                std::to_string(bricks_.size()) + " ranks");
}

Box Layout::cells(int rank) const {
  Box b;
  for (int d = 0; d < 3; ++d) b.lo[d] = cuts_[d][bricks_[rank][d]], b.hi[d] = cuts_[d][bricks_[rank][d] + 1];
  return b.empty() ? Box{} : b;
}

Box Layout::faces(int d, int rank) const {
  Box b = cells(rank);
  if (b.empty()) return b;
  if (!periodic_[d] && b.hi[d] == n_[d]) ++b.hi[d];
  return b;
}

std::vector<Box> Layout::all_cells() const {
  std::vector<Box> all;
  for (int r = 0; r < ranks(); ++r) all.push_back(cells(r));
  return all;
}

std::vector<Box> Layout::all_faces(int d) const {
  std::vector<Box> all;
  for (int r = 0; r < ranks(); ++r) all.push_back(faces(d, r));
  return all;
}

Layout Layout::coarsened(const Grid& coarse, const Int3& ratio) const {
  auto cuts = cuts_;
  for (int d = 0; d < 3; ++d)
    for (int& c : cuts[d]) {
      if (c % ratio[d]) throw std::logic_error("a cut of the layout splits a particle cell");
      c /= ratio[d];
    }
  return Layout(coarse, cuts, bricks_);
}

std::vector<int> cuts_near(const Axis& axis, int p, int block, const std::vector<double>& inner_positions) {
  std::vector<int> cuts(p + 1, 0);
  cuts[p] = axis.n();
  for (int a = 1; a < p; ++a) {
    int best = 0;
    for (int c = 0; c <= axis.n(); c += block)
      if (std::abs(axis.node(c) - inner_positions[a - 1]) < std::abs(axis.node(best) - inner_positions[a - 1]))
        best = c;
    cuts[a] = std::max(best, cuts[a - 1]);
  }
  return cuts;
}

std::vector<int> cuts_even(const Axis& axis, int p, int block) {
  std::vector<int> cuts(p + 1);
  const long long blocks = axis.n() / block;
  for (int a = 0; a <= p; ++a) cuts[a] = int(blocks * a / p) * block;
  cuts[p] = axis.n();
  return cuts;
}

}  // namespace twogrid
