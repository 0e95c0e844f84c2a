// What a coupling asks of all particles before it begins: the largest values that fixed-point sums need, how many there
// are, and whether all can be served.
#pragma once

#include <mpi.h>

#include <array>

#include "coupling/particles/ledger.h"
#include "coupling/selection/selection.h"

namespace twogrid {

/// This rank's particles. Largest values; 0 without particles.
struct Survey {
  double radius = 0, minus_radius = -1e300;  ///< m
  double mass = 0;                           ///< kg
  double reaction = 0;                       ///< component of b' u_seen - I/D (N)
  double response = 0;                       ///< b' (kg/s)
  double flux_velocity = 0;                  ///< bound of its size (m/s)
  Sum volume, new_volume;                    ///< m3
  std::array<Sum, 3> impulse;                ///< kg m/s
  double impulse_size = 0;                   ///< sum of the sizes of its components (kg m/s)
  bool finite = true;                        ///< all positions, velocities and impulses are
  long long new_particles = 0;
};

/// All ranks' particles.
struct Census {
  double radius = 0, smallest_radius = 1e300;                      ///< m
  double mass = 0, reaction = 0, response = 0, flux_velocity = 0;  ///< largest, as in Survey
  long long particles = 0, new_particles = 0;                      ///< inside; of these, new
  double grown = 0;                                                ///< volume gained since the last coupling (m3)
  double terms = 1;                                                ///< particles that a node's sum can hold at most
  long long in_walls = 0, behind_walls = 0, tag_behind = -1;       ///< as in Selection

  bool several_sizes() const { return particles > 0 && radius > smallest_radius * (1 + 1e-9); }
};

/// Those that leave settle their account: impulses are added to the survey. interval (s): since the last coupling.
void survey_leaving(const Particles& p, const Selection& selection, double interval, Survey& mine);

/// Volume by which this rank's particles have become larger since the radius in kRestRadius, which is noted anew (m3).
double growth(const Particles& p, const Selection& selection);

/// node_volume: of the largest node (m3); grown: of this rank's particles (m3). Throws std::runtime_error with a
/// sentence, on all ranks, where particles are not finite or lie where they may not. Collective.
Census take_census(MPI_Comm comm, const Particles& p, const Selection& selection, const Survey& mine, double grown,
                   double node_volume);

}  // namespace twogrid
