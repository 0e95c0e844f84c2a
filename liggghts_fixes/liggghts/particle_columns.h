// Columns that LIGGGHTS keeps with every particle: they migrate and restart with it.
#pragma once

#include <string>

namespace LAMMPS_NS {
class FixPropertyAtom;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace twogrid {

/// A fix property/atom of this name, so many values a particle, all zero at first. A restart file's are taken over.
LAMMPS_NS::FixPropertyAtom* keep_with_particles(LAMMPS_NS::LAMMPS& lammps, const std::string& name, int columns);

/// Where the values of a fix property/atom of this name and one column lie now; null: there is none.
double* particle_property(LAMMPS_NS::LAMMPS& lammps, const std::string& name);

}  // namespace twogrid
