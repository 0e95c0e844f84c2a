// Error of the coupling in time, measured where a coupling is checked: what the particles felt between couplings was
// held; at the coupling it jumps to its new value.
#pragma once

#include <mpi.h>

#include <vector>

#include "coupling/forces/interval_end.h"
#include "coupling/particles/particles.h"

namespace twogrid {

class CouplingError {
 public:
  /// The forces on `who` at the interval's end, before the coupling; drag[q] belongs to who[q]. Local.
  void remember(const Particles& p, const std::vector<int>& who, const std::vector<ImplicitDrag>& drag);
  /// After it: half the change of the forces on the same particles, root mean square over that of the forces
  /// themselves. Collective.
  double measure(MPI_Comm comm, const Particles& p, const std::vector<int>& who) const;

 private:
  std::vector<Vec3> before_;
};

}  // namespace twogrid
