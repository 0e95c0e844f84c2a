// Before LIGGGHTS sorts particles into cells: it doesn't survive one that is nowhere.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Throws std::runtime_error with a sentence where a particle of this rank has a position that is not a number. Not
/// collective: the other ranks go on.
void check_positions(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
