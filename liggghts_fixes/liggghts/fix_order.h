// The order of LIGGGHTS' fixes, which is the order in which they act.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Moves all fixes of the style, each followed by its fixes property/atom "<id>_state" and "<id>_step", behind the last
/// fix that adds forces. Fixes that overwrite forces (freeze, setforce, ...) and come last keep their place behind. The
/// indices that Atom holds are moved along. Only between runs. Not collective (the list is the same on all ranks).
void move_behind_forces(LAMMPS_NS::LAMMPS& lammps, const char* style);

}  // namespace twogrid
