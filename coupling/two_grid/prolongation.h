// Prolongation of the void fraction: nodes -> fine cells, constant or linear in each block.
#pragma once

#include <mpi.h>

#include "cfd/grid/layout.h"
#include "cfd/parallel/block_exchange.h"
#include "coupling/settings.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class Prolongation {
 public:
  /// Collective. eps_min bounds the linear profile from below.
  Prolongation(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& grid, Prolong kind,
               double eps_min);

  /// node covers own nodes and a halo of one (filled here when needed); fine covers own cells and a halo of two, filled
  /// here: owners' values, and beyond sides that are not periodic copies of the cell at the side. Collective.
  /// Linear: e_n + sum_d g_d (x - x_n), g_d the smaller of the two one-sided slopes (zero where they differ in sign),
  /// scaled back so that eps_min <= eps <= 1. The block's mean stays e_n: no volume is gained or lost. Where bodies stand,
  /// x_n is the centre of the open part, there is no slope towards a node behind a wall, and families of nodes
  /// (open_nodes.h) are constant.
  void operator()(CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const;
  /// The same, constant in each block.
  void constant(const CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const;

 private:
  void fill_halo(CellField<FineGrid>& fine) const;

  const FineGrid fine_;
  ParticleGrid grid_;
  Prolong kind_;
  double eps_min_;
  Box own_nodes_, own_cells_;
  BlockExchange node_halo_, fine_halo_;
};

}  // namespace twogrid
