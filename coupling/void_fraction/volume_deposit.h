// Solid volume of the particles on the nodes of the particle grid.
//
//   centroid    all of V_p to the node that holds the centre
//   trilinear   between the eight node centres around it
//   exact       the intersection of sphere and node (sphere_overlap.h); what sticks out at a wall goes to the node
//               there
//   cube        spread evenly over a cube of given edge, shifted inside at walls (Link et al., porous cube)
//
// Where bodies stand, what would go to a closed node, or to one that the particle's own node doesn't see, stays in the
// own node, and families of nodes (open_nodes.h) have their sum at their master.
//
// Each particle's volume is rounded once to an integer multiple of a unit, and its parts are integers that add up to
// it: sums are exact, and the same bits for any number of ranks and any order of particles. A node may hold 16 times
// its own volume, or 16 of the largest particles, before the sum overflows.
#pragma once

#include <mpi.h>

#include <vector>

#include "coupling/particles/particles.h"
#include "coupling/settings.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/window.h"

namespace twogrid {

class VolumeDeposit {
 public:
  /// Collective.
  VolumeDeposit(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const ParticleRegion& region,
                Deposit kind, double cube_edge);

  /// Particles are elsewhere now. Collective.
  void move_region(const ParticleRegion& region);
  /// Makes room for spheres of this radius; `largest_radius` is the same on all ranks. Collective if it has grown.
  void prepare(double largest_radius);
  /// Volume of the particles listed in `who`, in units of scale(), on the rank's own nodes (volume covers them).
  /// Collective. places: nodes or corners of `who` in a window of the same nodes and weights, if they are known.
  void operator()(const Particles& p, const std::vector<int>& who, Array3<long long>& volume,
                  const Places* places = nullptr);
  /// A volume as the integer with which it is deposited.
  const FixedPoint& scale() const { return scale_; }

 private:
  void make_window();
  void intersect_sphere(const double x[3], double radius, long long total);
  void add_seen(const Particles& p, const std::vector<int>& who);

  MPI_Comm comm_;
  ParticleGrid grid_;
  Layout nodes_;
  ParticleRegion region_;
  Deposit kind_;
  double cube_edge_, node_volume_, radius_ = 0;
  Window window_;
  Array3<long long> sum_;  // on the window
  Places places_;          // where they are not known
  SeenNodes seen_{};       // scratch, where bodies stand
  FixedPoint scale_;
  std::vector<double> beyond_;  // scratch of the exact intersection: volumes beyond the corners of the nodes cut
};

}  // namespace twogrid
