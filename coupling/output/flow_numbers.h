// What start_up.h follows, measured.
#pragma once

#include <mpi.h>

#include "cfd/fluid/fluid.h"
#include "coupling/output/start_up.h"
#include "coupling/particles/particles.h"

namespace twogrid {

/// Now. pressure_drop (Pa): of the last interval. Solids: mean height (m, along `up`; the places in periodic directions
/// don't count) and mean of v2/2 (m2/s2) by volume, of the particles that take part; fluid: mean of u2/2 over the open
/// volume. The same bits on all ranks. Collective.
FlowNumbers flow_numbers(MPI_Comm comm, const Fluid& fluid, const Particles& particles, const Vec3& up,
                         double pressure_drop);

}  // namespace twogrid
