// After the fluid has advanced, particle by particle: the kick of the implicit drag, what the particle reads now, and
// its drag coefficient by the drag law.
#pragma once

#include <vector>

#include "coupling/forces/drag.h"
#include "coupling/forces/interval_end.h"
#include "coupling/forces/step_forces.h"
#include "coupling/particles/ledger.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/reader.h"

namespace twogrid {

struct GatherInputs {
  /// Loaded: what particles see and eps; velocity; with kick, mean velocity, where it is another; formulation A: the
  /// residual force, last.
  const Reader& reader;
  const Places& places;  ///< of `who` in it
  const DragLaw& law;
  const StepForces& forces;   ///< knows a particle's decay over a DEM step
  double density, viscosity;  ///< of the fluid
  double interval;            ///< D (s)
  double read_length;         ///< of what a particle reads (m)
  bool kick;                  ///< the fluid has advanced
  bool mean_loaded;           ///< its mean velocity over the interval is another than that of now
  bool residual;              ///< formulation A
  bool drag_over_eps;         ///< the pressure gradient's force is in the drag: b = b_p/eps (formulation B, one size)
  const double* size_ratio;   ///< diameters over the local mean; null: 1
};

/// This rank's largest values, and sums.
struct GatherMaxima {
  double drag = 0, drag_coefficient = 0;  ///< N, kg/s
  double drag_number = 0;                 ///< D over response time
  double follow = 0;                      ///< time to cross what is read over response time
  double speed = 0;                       ///< m/s
  std::array<Sum, 3> kick;                ///< kg m/s
  double kick_size = 0;                   ///< sum of the sizes of its components (kg m/s)
};

/// Adds K/m to the velocity, K = b' (mean u - u_ref) D, u_ref: u as read at the last coupling, by the same weights. Then
/// stores u, eps, the residual's part of the pressure force, b and the columns that depend on b, and sets the impulse of
/// the next interval to zero. Local.
void correct_and_gather(Particles& p, const std::vector<int>& who, const std::vector<ImplicitDrag>& drag,
                        const GatherInputs& taking, GatherMaxima& taken);

}  // namespace twogrid
