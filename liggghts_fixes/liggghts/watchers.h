// Who may look at the forces of a step.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Whether something may look at per-atom values between outputs: any fix that isn't known not to.
bool any_watchers(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
