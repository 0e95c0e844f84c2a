// Nodes where bodies stand in the fluid's grid (cfd/measures/open_shares.h). Without bodies there is no such object.
//
//   open part  V_n = sum of theta_c V_c over the node's fine cells; a node without an open cell is closed: it holds and
//              gives nothing
//   families   A node of which less than kOwnValue is open has no value of its own: few particles fit in it, and weights
//              made for whole nodes give it too much of them. It joins the neighbour with which it shares the largest
//              open area (equal ones: the lower index) of those that have a value, or else of those that have joined
//              one; what lies deeper than kDeepest such steps begins families of its own. A family holds the sums of its
//              members over the sum of their open parts, and all members show its value. Its master is the node that
//              began it. This goes by the geometry alone, not by the particles' size: families stay over a run and its
//              restarts, and of nodes that are small against particles the whole ones are no better.
//   sight      Nodes next to each other (26 of them) see each other if open cells of either are connected by open faces
//              within the box that the two span. What a particle gives to a node that its own doesn't see goes to its
//              own node, and so does that node's weight when it reads.
//
// A node whose open cells are not connected within it is split: it smears over the wall in it. Such nodes are counted;
// slivers at a corner, which a wall that touches a node leaves, don't make one.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/block_exchange.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

template <class T>
Slot<T> slot_of(Array3<T>& a) {
  return {a.box(), a.data(), 1};
}

class OpenNodes {
 public:
  /// Packing in a round vessel, trilinear, nodes of 2, 3 and 4 diameters: eps at the wall is off by 0.037, 0.026, 0.029
  /// (rms) with 1/3; by 0.017 in all three with 1/2, and by up to 5 without families.
  static constexpr double kOwnValue = 0.5;

  /// search: nodes around a closed one among which an open one is looked for. The fluid must have open shares. Collective.
  OpenNodes(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid, const Int3& search);

  /// Volumes of own nodes (m3): the open part; of the family at its master, 0 at others; of the family at all members.
  const Array3<double>& open_part() const { return part_; }
  const Array3<double>& volumes() const { return volume_; }
  double family_volume(int i, int j, int k) const { return family_(i, j, k); }
  bool in_family(int i, int j, int k) const { return family_(i, j, k) != part_(i, j, k); }
  /// Centre of the open part less that of the node, in direction d (m); own nodes and a halo of one, of several fine
  /// cells.
  double off_centre(int d, int i, int j, int k) const { return off_[d](i, j, k); }

  /// Bits of own nodes: seen() of the neighbour at each offset; that of offset 0: open.
  const Array3<long long>& sight() const { return sight_; }
  static constexpr long long seen(int x, int y, int z) { return 1LL << (x + 1 + 3 * (y + 1) + 9 * (z + 1)); }
  static constexpr long long kOpen = 1LL << 13;
  bool sees(int i, int j, int k, int d, int side) const {
    return (sight_(i, j, k) & seen(d == 0 ? side : 0, d == 1 ? side : 0, d == 2 ? side : 0)) != 0;
  }
  const Int3& search() const { return search_; }

  /// Sums of the members to their masters; members that are none get zero. T: long long, double, FourNumbers,
  /// FourWholeNumbers. The same bits on any number of ranks. All collective.
  template <class T>
  void gather_up(const Slot<T>& node) const {
    pass(node, true, false);
  }
  /// The masters' values to all members.
  template <class T>
  void hand_down(const Slot<T>& node) const {
    pass(node, false, true);
  }
  /// The sums of the members to all members.
  template <class T>
  void total(const Slot<T>& node) const {
    pass(node, true, true);
  }
  /// Mean over the members, weighed by open parts.
  void average(Array3<double>& node) const;

  /// Of all ranks.
  struct Figures {
    long long cut = 0, closed = 0;  ///< nodes that are not wholly open; of these, without any open cell
    long long merged = 0;           ///< open, without a value of their own
    long long split = 0;            ///< two or more parts not connected within the node, slivers not counted
    double smallest = 1;            ///< volume of a family over that of its master, whole
  };
  const Figures& figures() const { return figures_; }

 private:
  struct Link {
    std::ptrdiff_t to, from;  // places in own nodes with a halo of one
  };
  struct FineCells;

  void measure(const Fluid& fluid, const ParticleGrid& grid);
  void look_around(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid);
  void found_families(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid);
  void join(MPI_Comm comm, const ParticleGrid& grid, long long deepest, Array3<long long>& depth);
  void link(MPI_Comm comm, const ParticleGrid& grid, const Array3<long long>& depth);
  void count(MPI_Comm comm, const ParticleGrid& grid);
  template <class T>
  void pass(const Slot<T>& node, bool up, bool down) const;

  Box own_, with_halo_;
  Int3 search_;
  BlockExchange halo_;
  Array3<double> part_, volume_, family_;
  std::array<Array3<double>, 3> off_;
  Array3<long long> sight_;
  std::array<Array3<double>, 6> area_;        // open area towards each neighbour (m2); while families are founded
  Array3<long long> parent_;                  // direction of the neighbour that a node has joined, 2 d + high; -1: none
  std::vector<std::vector<Link>> up_, down_;  // by depth of the upper one
  Figures figures_;
};

}  // namespace twogrid
