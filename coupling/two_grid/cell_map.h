// The map between the two grids for what lies in cells: temperature, vorticity, and sources of scalars.
//   mean     fine cells -> nodes   c_n = sum_c V_c w_c c_c / W_n,  W_n = sum_c V_c w_c over the node's fine cells (0
//                                  where W_n = 0; with open shares w_c is theta_c times what is given)
//   spread   nodes -> fine cells   V_c s_c = q_n V_c w_c / W_n, the transpose of mean
// so that sum_c V_c s_c c_c = sum_n q_n c_n for any q and c, and sum_c V_c s_c = sum_n q_n. w: void fraction, or 1. That
// of faces: map.h.
#pragma once

#include <array>

#include "cfd/grid/field.h"
#include "cfd/measures/open_shares.h"
#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/vectorised.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class CellMap {
 public:
  /// own: the rank's own nodes; all of a node's fine cells are of its rank.
  /// open: of the fluid, must outlive this; null: all is open.
  CellMap(const FineGrid& fine, const ParticleGrid& grid, const Box& own, const OpenShares* open = nullptr)
      : fine_(fine), grid_(grid), own_(own), open_(open) {}

  using Cells = std::array<const CellField<FineGrid>*, 4>;
  /// Sets component q of own nodes to the mean of cells[q], where that is not null. weight: w above zero; null: 1. Local;
  /// collective where bodies stand: families of nodes (open_nodes.h) are one node.
  void mean(const Cells& cells, const CellField<FineGrid>* weight, const Slot<FourNumbers>& node) const;
  /// node: sums over own nodes, in units of scale[0] (components 0-2) and scale[1] (component 3). cells[q]: set to s of
  /// component q in own fine cells, where not null; per m3. Local, or collective as mean().
  void spread(const Slot<FourWholeNumbers>& node, const std::array<FixedPoint, 2>& scale,
              const CellField<FineGrid>* weight, const std::array<CellField<FineGrid>*, 4>& cells) const;

 private:
  double volume(int i, int j, int k) const {
    return fine_.axis[0].width(i) * fine_.axis[1].width(j) * fine_.axis[2].width(k);
  }
  /// w of a cell.
  double weight(int i, int j, int k, const CellField<FineGrid>* given) const {
    const double w = given ? (*given)(i, j, k) : 1.0;
    return open_ ? w * open_->theta()(i, j, k) : w;
  }
  double weight_of(int I, int J, int K, const CellField<FineGrid>* weight) const;
  Array3<double> inverse_weights(const CellField<FineGrid>* weight) const;

  FineGrid fine_;
  ParticleGrid grid_;
  Box own_;
  const OpenShares* open_;
};

}  // namespace twogrid
