// Particles that fixes insert/... will have added by a later step, without a run: for a plan.
#pragma once

#include <string>
#include <vector>

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

/// Insertions that are due once, and for the last time, after the present step, up to step `end`: their fixes, by ID. Local.
std::vector<std::string> last_insertions(LAMMPS_NS::LAMMPS& lammps, long long end);
/// Particles that these had room for less than the script asks them for. Local.
double without_room(LAMMPS_NS::LAMMPS& lammps, const std::vector<std::string>& ids);

}  // namespace twogrid
