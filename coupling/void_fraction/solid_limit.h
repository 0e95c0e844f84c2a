// The lower bound of the void fraction: no node may hold more solid than (1 - eps_min) of its (open) volume.
//
// move: what is too much goes to neighbours that have room, in proportion to their room; where none of the six has any,
//   one step along the shortest ways to nodes with room; and so on until all is placed. Nothing is thrown away. If no
//   node that can be reached has room, what is left stays where it is, and `unplaced` says how much. Ways lead through
//   open faces only.
// clip: what is too much is thrown away, as other codes do.
// Works on the integers of the deposition (volume_deposit.h): the result doesn't depend on the number of ranks.
#pragma once

#include <mpi.h>

#include "cfd/parallel/block_exchange.h"
#include "coupling/settings.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class SolidLimit {
 public:
  struct Result {
    double displaced = 0;  ///< volume moved, or thrown away (m3)
    double unplaced = 0;   ///< volume above the bound that found no room (m3)
    int sweeps = 0;
  };

  /// Collective.
  SolidLimit(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, EpsBound kind, double eps_min);

  /// solid: volume in units of scale, own nodes. Collective; the result is the same on all ranks.
  Result operator()(const FixedPoint& scale, Array3<long long>& solid);

 private:
  /// There is a neighbour, and no wall between. side: -1 below, 1 above.
  bool reaches(int i, int j, int k, int d, int side) const;
  void find_distances();
  void move_once();

  MPI_Comm comm_;
  ParticleGrid grid_;
  Box own_, with_halo_;  // a halo of one
  EpsBound kind_;
  double eps_min_;
  BlockExchange halo_;
  Array3<long long> most_;  // a node may hold; own nodes
  // Own nodes and a halo of one, made when first a node holds more.
  Array3<long long> room_;      // most - solid
  Array3<long long> distance_;  // steps to the nearest node with room
  Array3<long long> change_;    // what one sweep brings
  double unit_ = 0;             // for which most_ was computed
};

}  // namespace twogrid
