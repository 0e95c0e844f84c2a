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

#include <vector>

#include "coupling/particles/particles.h"
#include "coupling/two_grid/cell_map.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/map.h"
#include "coupling/two_grid/window.h"

namespace twogrid {

/// Whether a way of reading works on the fine cells themselves.
bool reads_fine_cells(Read read);
Spread spread_of(Read read);

/// Four values that particles read together: three components on faces, as the node's mean, and one value of the node;
/// or of any of the four the mean over the node's fine cells.
struct ReadGroup {
  const FaceField<FineGrid>* faces = nullptr;  ///< own faces and a halo of one; null: zero
  const Array3<double>* value = nullptr;       ///< own nodes; null: zero
  /// Of fine cells and a halo of one: the components are then the node's mean of eps_f u_f over its own void fraction,
  /// `value`. So they are the velocity inside the node also where the void fraction jumps at its sides: the flux eps u
  /// passes the jump unchanged, while u on the faces there is that of neither side.
  const CellField<FineGrid>* eps = nullptr;
  /// Component q is the mean of cells[q], where not null, weighed by volume, or volume times cell_weight (CellMap).
  CellMap::Cells cells{};
  const CellField<FineGrid>* cell_weight = nullptr;
};

class Reader {
 public:
  /// grid: the particle grid, or the fine cells as nodes of ratio 1. Collective.
  Reader(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid, const ParticleRegion& region, Read read,
         double width);

  const Window& window() const { return window_; }
  const Map& map() const { return map_; }

  /// Particles are elsewhere now; what was loaded is forgotten. Collective.
  void move_region(const ParticleRegion& region);
  /// Where the particles in `who` read.
  void find(const Particles& p, const std::vector<int>& who, Places& places) const;
  /// f(q, place) for every particle who[q]; the place is a node, corners, a stencil or seen nodes, for at() and react().
  template <class F>
  void at_places(const Particles& p, const std::vector<int>& who, const Places& places, F f) const {
    const std::size_t n = who.size();
    if (window_.spread() == Spread::kCell) {
      for (std::size_t q = 0; q < n; ++q) f(q, places.node[q]);
    } else if (window_.cut()) {
      SeenNodes seen;
      for (std::size_t q = 0; q < n; ++q) {
        window_.see(p.x[who[q]], seen);
        f(q, seen);
      }
    } else if (window_.spread() == Spread::kLinear) {
      for (std::size_t q = 0; q < n; ++q) f(q, places.corners[q]);
    } else {
      Stencil w;
      for (std::size_t q = 0; q < n; ++q) {
        window_.weights(p.x[who[q]], w);
        f(q, w);
      }
    }
  }

  /// Makes fields readable, group by group. Collective.
  void load(const std::vector<ReadGroup>& groups);
  /// The groups as loaded, on the window; for gather().
  const FourNumbers* field() const { return field_.data(); }
  const WindowShape& shape() const { return shape_; }
  /// The groups at a place.
  template <int kGroups, class Place>
  void at(const Place& place, Four* out) const {
    gather<kGroups>(place, shape_, field_.data(), out);
  }

  /// Reaction: three components and one coefficient, in whole numbers of units. sum(): on the window, for scatter().
  void clear_reaction();
  FourWholeNumbers* sum() { return sum_.data(); }
  template <class Place>
  void react(const Place& place, const Four& whole) {
    scatter(place, shape_, whole, sum_.data());
  }
  /// The same at x, which may lie anywhere.
  void react_at(const double x[3], const Four& whole);
  /// Sums of all ranks on faces: source (components 0-2) and beta (3), per volume. held_back: what nodes without a
  /// solved face kept of components 0-2. Collective.
  void collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back);
  /// The same sums on own fine cells, per volume: component q to cells[q], where not null, by the transpose of reading
  /// cells with this weight. Collective.
  void collect(const std::array<FixedPoint, 2>& scale, const CellField<FineGrid>* weight,
               const std::array<CellField<FineGrid>*, 4>& cells);

 private:
  Slot<FourNumbers> own_field(int group, int groups);
  Slot<FourWholeNumbers> own_sums();

  MPI_Comm comm_;
  Read read_;
  double width_;
  Map map_;
  CellMap cell_map_;
  Window window_;
  WindowShape shape_;
  bool around_ = false;                         // the window lies around own nodes: their values have their place in it
  std::vector<FourNumbers> field_, own_field_;  // on the window, groups together; own nodes' elsewhere
  std::vector<FourWholeNumbers> sum_, own_sum_;  // the same
  Array3<double> value_;                         // scratch of load(): of families of fine cells
};

}  // namespace twogrid
