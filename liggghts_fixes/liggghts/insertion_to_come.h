// Particles that fixes insert/... will have added by a later step, without a run: for a plan.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

struct ComingParticles {
  double number = 0;     ///< of all ranks
  bool at_most = false;  ///< as a region is filled up again and again, as far as it has emptied
};

/// Those that insertions would add after the present step, up to step `end`; the fixes take them for done. Local.
ComingParticles pass_insertions(LAMMPS_NS::LAMMPS& lammps, long long end);

/// Whether an insertion is due after the present step, up to step `end`. Local.
bool inserts_until(LAMMPS_NS::LAMMPS& lammps, long long end);

}  // namespace twogrid
