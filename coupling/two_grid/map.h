// The map between the two grids for what lies on faces (cells: cell_map.h; the void fraction's way down: prolongation.h):
//   mean    fine faces -> nodes   velocity, and everything that is read: mean over the block of one node, per direction
//   spread  nodes -> fine faces   momentum, the transpose of mean
// Block of node n, direction d: all faces normal to d that touch its fine cells. Each weighs W_nf, the part of its
// momentum volume (half of either neighbour cell) that lies inside the block; faces whose velocity is prescribed weigh
// zero. With the sum W_n over the block's faces,
//   mean     u_n = sum_f W_nf u_f / W_n            (0 where W_n = 0)
//   spread   V_f s_f = sum_n W_nf q_n / W_n,  V_f = sum_n W_nf: the part of the momentum volume inside the domain
// With open shares (cfd/measures/open_shares.h) each half of W_nf is weighed by theta of the cell it lies in, and closed
// faces weigh zero; V_f stays the whole volume, so that s_f comes with the factor theta_f that the momentum balance wants.
// So sum_f V_f s_f u_f = sum_n q_n u_n for any q and u, and sum_f V_f s_f = sum_n q_n but for nodes with W_n = 0.
// Families of nodes (open_nodes.h) are one node: their sums of W_nf u_f, W_nf and q_n are shared by all members.
#pragma once

#include <mpi.h>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/vectorised.h"
#include "coupling/settings.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/open_faces.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

template <class T>
using NodeVector = std::array<T, 3>;

class NodeSpread;

class Map {
 public:
  /// Keeps the fluid's face states of now; its open shares must outlive this. Collective.
  Map(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid);

  const ParticleGrid& grid() const { return grid_; }
  const Layout& layout() const { return layout_; }
  /// The rank's own nodes.
  const Box& own() const { return own_; }
  /// Own fine faces normal to d.
  const Box& faces(int d) const { return faces_[d]; }
  /// V_f of an own face (m3).
  double face_volume(int d, int i, int j, int k) const {
    const std::array<const double*, 3> w{width_[0].data(), width_[1].data(), width_[2].data()};
    const Int3 c{i, j, k};
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    return face_width_[d][c[d]] * (w[e][c[e]] * w[f][c[f]]);
  }

  /// Sum over the row of own faces of `density` V_f.
  double integral(int d, int j, int k, const double* density) const;

  /// `face` covers own faces and a halo of one, filled; node: own nodes, of whose groups components 0-2 are set. eps:
  /// of fine cells and a halo of one: then the mean is that of eps_f times the face's value, eps_f by volume as the
  /// fluid has it. Collective where bodies stand.
  void mean(const FaceField<FineGrid>& face, const Slot<FourNumbers>& node,
            const CellField<FineGrid>* eps = nullptr) const;
  /// node: own nodes' sums over the node, in units of scale[0] (components 0-2, N) and scale[1] (component 3, kg/s);
  /// source (0-2) and beta (3): per volume, on own faces. Returns what nodes without a solved face held back of
  /// components 0-2, summed over own nodes. The map must live as long as source and beta are used. Collective.
  Vec3 spread(const Slot<FourWholeNumbers>& node, const std::array<FixedPoint, 2>& scale, NodeSpread& source,
              NodeSpread& beta) const;

 private:
  template <class Value>
  double open_sum(int d, int I, int J, int K, Value value) const;
  __attribute__((noinline)) void mean_of_open(const FaceField<FineGrid>& face, const Slot<FourNumbers>& node,
                                              const CellField<FineGrid>* eps) const;

  ParticleGrid grid_;
  Layout layout_;
  Box own_;
  const OpenShares* shares_;  // of the fluid; null: all is open
  std::array<Box, 3> faces_;
  FineGrid fine_;
  std::array<std::vector<double>, 3> width_;       // of fine cells (m)
  std::array<std::vector<double>, 3> face_width_;  // of momentum volumes, their part inside the domain (m)
  // Face i of direction d takes the share `above` of node [i / r] and 1 - above of the node below.
  std::array<std::vector<double>, 3> above_;
  std::array<std::vector<double>, 3> upper_half_;   // share of the cell above in a face's width; only with open shares
  std::array<std::vector<double>, 3> above_share_;  // of the cell above a face in the mean of eps on it
  std::array<std::vector<int>, 3> block_;           // node of fine cell i; of the last face: one beyond the last
  std::array<std::vector<double>, 3> half_;         // [d][m n + N]: width inside block N of its face m = 0 ... r
  NodeVector<CellField<ParticleGrid>> inverse_;     // 1 / W_n, own nodes; of families the sum's
  std::array<bool, 3> holds_back_;                  // some W_n is zero
  std::array<OpenFaces, 3> open_;                   // all faces of own nodes
  mutable std::vector<double> row_, flux_;          // scratch of mean()
  mutable std::vector<FourNumbers> sums_;           // the same, where bodies stand
  Box with_below_;
  BlockExchange below_;

  friend class NodeSpread;
};

/// What spread() makes: it holds values of nodes, and gives those of faces row by row.
class NodeSpread : public FaceRows {
 public:
  void row(int d, int i, int j, int k, int n, double* out) const override;
  /// All own faces of direction d (tests).
  void field(int d, Array3<double>& out) const;

 private:
  void fill_row(int d, int i, int j, int k, int n, double* out) const;
  void fill_open_row(int d, int i, int j, int k, int n, double* out) const;

  const Map* map_ = nullptr;
  NodeVector<CellField<ParticleGrid>> share_;  // q_n / W_n on own nodes and those below

  friend class Map;
};

}  // namespace twogrid
