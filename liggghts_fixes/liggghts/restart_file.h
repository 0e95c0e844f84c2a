// What the restart file that a script has read holds of fixes.
#pragma once

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Values a particle of the fix property/atom of this id; -1: it holds none.
int values_in_restart(LAMMPS_NS::LAMMPS& lammps, const std::string& id);
/// Throws std::invalid_argument where it holds the columns of this name, but not so many.
void check_columns_in_restart(LAMMPS_NS::LAMMPS& lammps, const std::string& name, int columns);
/// Throws std::invalid_argument where a checkpoint is to be read (not empty) by particles that no restart file has brought.
void check_restarted(bool restarted, const std::string& checkpoint);
/// The ID of a fix twogrid whose state it holds; empty: of none.
std::string id_in_restart(LAMMPS_NS::LAMMPS& lammps);

/// Before the first run: what it holds of the particles for fixes property/atom goes to them once more. LIGGGHTS changes
/// some of it when it makes other fixes (insert/stream counts the steps anew up to which its particles are led).
/// only: of the fix of this ID; null: of all.
void take_columns_again(LAMMPS_NS::LAMMPS& lammps, const char* only = nullptr);

}  // namespace twogrid
