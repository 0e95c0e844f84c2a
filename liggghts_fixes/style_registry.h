// Adds this project's styles to a LIGGGHTS that was built without them.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Registers fix twogrid, and a `run` command that first moves fix twogrid behind all fixes that add forces: the
/// drag rescales the total force, so that it has to come last. To be called once, right after LAMMPS is
/// made. Not collective.
void register_styles(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
