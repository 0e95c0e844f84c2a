// Adds this project's styles to a LIGGGHTS that was built without them.
#pragma once

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Registers fix twogrid, and a `run` command that first moves fix twogrid behind all fixes that add forces: the
/// drag rescales the total force, so that it has to come last. To be called once, right after LAMMPS is
/// made. Not collective.
void register_styles(LAMMPS_NS::LAMMPS& lammps);

/// Puts our own code, of the same results to the last bit, in the place of LIGGGHTS' for contacts of particles
/// (pair_style gran model hooke/stiffness tangential history), plane walls of that law, and nve/sphere. kernel: "auto",
/// "AVX2", "AVX-512", or "stock", which leaves LIGGGHTS as it is. Throws std::invalid_argument for a kernel that the
/// processor can't run. Call once, before the script is read.
void register_particles(LAMMPS_NS::LAMMPS& lammps, const std::string& kernel);

}  // namespace twogrid
