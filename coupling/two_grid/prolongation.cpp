#include "coupling/two_grid/prolongation.h"

#include <algorithm>
#include <cmath>

#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

Prolongation::Prolongation(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& grid,
                           Prolong kind, double eps_min)
    : fine_(fine), grid_(grid), kind_(kind), eps_min_(eps_min) {
  const int rank = rank_of(comm);
  const Layout nodes = node_layout(layout, grid);
  own_nodes_ = nodes.cells(rank);
  own_cells_ = layout.cells(rank);
  node_halo_ =
      BlockExchange(comm, nodes.all_cells(), with_halo(nodes.all_cells(), {1, 1, 1}), grid.n(), grid.periodic());
  fine_halo_ =
      BlockExchange(comm, layout.all_cells(), with_halo(layout.all_cells(), {2, 2, 2}), fine.n(), fine.periodic());
}

void Prolongation::constant(const CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const {
  const Int3 r = grid_.ratio;
  for_each(own_cells_, [&](int i, int j, int k) { fine(i, j, k) = node(i / r[0], j / r[1], k / r[2]); });
  fill_halo(fine);
}

void Prolongation::operator()(CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const {
  if (kind_ == Prolong::kConstant || grid_.ratio == Int3{1, 1, 1}) {
    constant(node, fine);
    return;
  }
  node_halo_.bring<double>(node);
  const Int3 n = grid_.n();
  const OpenNodes* const open = grid_.open_nodes();
  for_each(own_nodes_, [&](int I, int J, int K) {
    const Int3 c{I, J, K};
    const auto middle = [&](int d, const Int3& at) {
      const double x = grid_.axis[d].centre(at[d]);
      return open ? x + open->off_centre(d, at[0], at[1], at[2]) : x;
    };
    const bool one_value = open && open->in_family(I, J, K);
    Vec3 x{0, 0, 0};
    const double e = node(I, J, K);
    const Box block = grid_.block(I, J, K);
    Vec3 slope{0, 0, 0};
    double deviation = 0;  // largest of the profile
    for (int d = 0; d < 3; ++d) {
      const Axis& a = grid_.axis[d];
      x[d] = middle(d, c);
      if (grid_.ratio[d] == 1 || one_value || (!a.periodic() && (c[d] == 0 || c[d] == n[d] - 1))) continue;
      if (open && !(open->sees(I, J, K, d, -1) && open->sees(I, J, K, d, 1))) continue;
      Int3 lo = c, hi = c;
      --lo[d], ++hi[d];
      const double below = (e - node(lo[0], lo[1], lo[2])) / (x[d] - middle(d, lo));
      const double above = (node(hi[0], hi[1], hi[2]) - e) / (middle(d, hi) - x[d]);
      if (below * above > 0) slope[d] = std::abs(below) < std::abs(above) ? below : above;
      const Axis& f = fine_.axis[d];
      deviation += std::abs(slope[d]) * std::max(x[d] - f.centre(block.lo[d]), f.centre(block.hi[d] - 1) - x[d]);
    }
    if (deviation > 0) {
      const double room = std::max(0.0, std::min(1 - e, e - eps_min_));
      if (deviation > room)
        for (double& s : slope) s *= room / deviation;
    }
    for_each(block, [&](int i, int j, int k) {
      const Axis* f = fine_.axis.data();
      fine(i, j, k) = e + slope[0] * (f[0].centre(i) - x[0]) + slope[1] * (f[1].centre(j) - x[1]) +
                      slope[2] * (f[2].centre(k) - x[2]);
    });
  });
  fill_halo(fine);
}

void Prolongation::fill_halo(CellField<FineGrid>& fine) const {
  fine_halo_.bring<double>(fine);
  if (own_cells_.empty()) return;
  // Copies beyond the sides, one direction after the other, so that edges and corners are filled too.
  Box done = fine.box();
  for (int d = 0; d < 3; ++d)
    if (!fine_.axis[d].periodic()) {
      done.lo[d] = std::max(done.lo[d], 0);
      done.hi[d] = std::min(done.hi[d], fine_.axis[d].n());
    }
  for (int d = 0; d < 3; ++d) {
    if (fine_.axis[d].periodic()) continue;
    const int n = fine_.axis[d].n();
    Box beyond = done;
    beyond.lo[d] = fine.box().lo[d], beyond.hi[d] = 0;
    for_each(beyond, [&](int i, int j, int k) {
      Int3 c{i, j, k};
      c[d] = 0;
      fine(i, j, k) = fine(c[0], c[1], c[2]);
    });
    beyond.lo[d] = n, beyond.hi[d] = fine.box().hi[d];
    for_each(beyond, [&](int i, int j, int k) {
      Int3 c{i, j, k};
      c[d] = n - 1;
      fine(i, j, k) = fine(c[0], c[1], c[2]);
    });
    done.lo[d] = fine.box().lo[d], done.hi[d] = fine.box().hi[d];
  }
}

}  // namespace twogrid
