// What particles read from the fluid, and the way their reaction goes back.
//
//   READ = R o M     M: mean over the fine faces of a node (map.h), R: weights of the nodes at the particle (window.h)
//   reaction         the transpose, M^T o R^T: particle -> nodes (fixed-point sums) -> faces
//
//   read             nodes           R
//   cell             particle grid   the node that holds the centre
//   trilinear        particle grid   between node centres
//   fine             fine cells      the fine cell that holds the centre
//   fine/trilinear   fine cells      between fine cell centres
//   kernel           fine cells      quadratic B-spline of given full width
//   cube             fine cells      mean over a cube of given edge
#pragma once

#include <mpi.h>

#include "fixed_point.h"
#include "map.h"
#include "window.h"

namespace twogrid {

/// Whether a way of reading works on the fine cells themselves.
bool reads_fine_cells(Read read);
Spread spread_of(Read read);

class Reader {
 public:
  /// grid: the particle grid, or the fine cells as nodes of ratio 1. Collective.
  Reader(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid, const ParticleRegion& region, Read read,
         double width);

  const Window& window() const { return window_; }
  const Map& map() const { return map_; }
  void weights(const double x[3], Stencil& s) const { window_.weights(x, s); }
  /// Whether a particle reads one node only; then node() says which, and stands for its weights.
  bool single() const { return window_.spread() == Spread::kCell; }
  std::ptrdiff_t node(const double x[3]) const {
    return window_field_[0].index(window_.span(0).find(x[0]), window_.span(1).find(x[1]), window_.span(2).find(x[2]));
  }

  /// Whether a particle reads between node centres; then corners() stand for its weights.
  bool linear() const { return window_.spread() == Spread::kLinear; }
  Corners corners(const double x[3]) const { return window_.corners(x); }

  /// Makes these fields readable. Velocity and residual: own faces and a halo of one; eps: own nodes. Collective.
  void load(const FaceField<FineGrid>& velocity, const Array3<double>& eps);
  void load(const FaceField<FineGrid>& velocity, const Array3<double>& eps, const FaceField<FineGrid>& residual);
  void load(const FaceField<FineGrid>& velocity);

  enum Field { kVelocity = 0, kEps = 3, kResidual = 4, kFields = 7 };
  /// The first N fields at a particle, in the order of Field: 3 velocity, 4 and eps, 7 and residual.
  template <int N, class Place>
  void at(const Place& s, double* out) const {
    const double* field[N];
    for (int q = 0; q < N; ++q) field[q] = window_field_[q].data();
    gather<N>(s, window_field_[0], field, out);
  }

  template <int N>
  void at(std::ptrdiff_t node, double* out) const {
    for (int q = 0; q < N; ++q) out[q] = window_field_[q].data()[node];
  }

  /// Reaction: three components and one coefficient.
  static constexpr int kReactions = 4;
  void clear_reaction();
  template <class Place>
  void react(const Place& s, const std::array<long long, kReactions>& q) {
    for (int c = 0; c < kReactions; ++c) scatter(s, q[c], window_sum_[c]);
  }
  void react(std::ptrdiff_t node, const std::array<long long, kReactions>& q) {
    for (int c = 0; c < kReactions; ++c) window_sum_[c].data()[node] += q[c];
  }
  /// Sums of all ranks on faces: source (components 0-2) and beta (3), per volume. held_back: what nodes without a
  /// solved face kept of components 0-2. Collective.
  void collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back);

 private:
  Map map_;
  Window window_;
  NodeVector<CellField<ParticleGrid>> velocity_, residual_;  // own nodes
  std::array<Array3<double>, kFields> window_field_;
  std::array<Array3<long long>, kReactions> window_sum_, node_sum_;
  std::array<CellField<ParticleGrid>, kReactions> node_reaction_;  // own nodes
};

}  // namespace twogrid
