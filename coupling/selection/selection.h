// Which of a rank's particles a coupling sees: those in the fluid, those that have left it since the last coupling and
// have an account to settle, and of the former those that are new.
#pragma once

#include <mpi.h>

#include <vector>

#include "coupling/particles/particles.h"
#include "coupling/two_grid/particle_grid.h"
#include "coupling/two_grid/window.h"

namespace twogrid {

class Selection {
 public:
  /// window: where a particle of this rank may be; it must live as long. grid: where bodies stand, a particle is in the
  /// fluid if the node that holds its centre is open, or one beside it. Collective.
  Selection(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const Window& window,
            const ParticleRegion& region);

  /// After the window's. Collective.
  void move_region(const ParticleRegion& region);
  /// Particles that are in neither list are made outside ones. Local.
  void find(const Particles& p);
  /// New ones among inside(). any: there may be some.
  void find_new(const Particles& p, bool any);

  const std::vector<int>& inside() const { return inside_; }
  const std::vector<int>& leaving() const { return leaving_; }
  const std::vector<int>& new_ones() const { return new_; }
  /// Among inside() and among those that are not: centres in closed nodes. Of this rank.
  long long in_walls() const { return in_walls_; }
  long long behind_walls() const { return behind_walls_; }
  long long tag_behind() const { return tag_behind_; }  ///< of one of these; -1: none
  const Window& window() const { return window_; }
  double reach() const { return region_.reach; }
  /// All particles of this rank that are inside are where they may be.
  bool covered() const { return covered_; }
  /// Looks for particles that can't be served; tag of one of them, or -1.
  long long find_bad(const Particles& p, double& not_finite, double& uncovered) const;

  /// No fluid, and known: should it come in, its path began here, and it pushes fluid aside as any particle that moves.
  static void set_outside(const Particles& p, int i);

 private:
  void find_bounds();
  void look_for_walls(const Particles& p);

  MPI_Comm comm_;
  ParticleGrid grid_;
  Layout nodes_;
  Window open_;  // one node a particle; only where bodies stand
  const Window& window_;
  ParticleRegion region_;
  Vec3 inside_lo_, inside_hi_;  // between these a particle counts as inside, a little beyond the sides too (m)
  Vec3 surely_lo_, surely_hi_;  // and is where a particle of this rank may be
  std::vector<int> inside_, leaving_, new_;
  std::vector<int> others_;  // scratch of find()
  bool covered_ = true;
  long long in_walls_ = 0, behind_walls_ = 0, tag_behind_ = -1;
};

}  // namespace twogrid
