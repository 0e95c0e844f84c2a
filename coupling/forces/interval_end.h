// What an interval that ends leaves behind, particle by particle: path, impulse, implicit drag, and what is to be
// checked of all particles.
#pragma once

#include <vector>

#include "cfd/grid/box.h"
#include "cfd/parallel/vectorised.h"
#include "coupling/particles/particles.h"
#include "coupling/selection/census.h"

namespace twogrid {

/// Of a particle, from end_of_interval() to correct_and_gather(): the drag that follows the fluid while it advances. u_ref: u as the
/// particle read it at the interval's begin (less what holding the flux has changed since).
struct alignas(64) ImplicitDrag {
  Four given;  ///< b' u_ref - I/D, three components (N); b' (kg/s)
  Four seen;   ///< u_ref, three components (m/s); 1/m, or 0 where something holds the particle (1/kg)
};

struct IntervalEnd {
  double interval;       ///< D (s)
  double repeated;       ///< time in which the force was that of the step before, and is not in the impulses yet (s)
  double extrapolation;  ///< weight of the extrapolation of a particle's mean velocity to the interval's end
  const Vec3* change;    ///< u_read - u_seen of `who` (m/s); null: they are the same
};

/// For every particle in `who`: path velocity and position noted in its state; drag[q] and flux_velocity[q] (m/s, three
/// components) belong to who[q]; survey: this rank's. Particles that are not known are new. Local.
void end_of_interval(const Particles& p, const std::vector<int>& who, const IntervalEnd& end,
                     std::vector<ImplicitDrag>& drag, std::vector<FourNumbers>& flux_velocity, Survey& survey);

/// The same at the beginning, where no interval ends: state all zero but for position and velocity. Local.
void begin(const Particles& p, const std::vector<int>& who, std::vector<ImplicitDrag>& drag,
           std::vector<FourNumbers>& flux_velocity, Survey& survey);

}  // namespace twogrid
