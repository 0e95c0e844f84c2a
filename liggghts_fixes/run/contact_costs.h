// What a contact of a script's contact law costs on this machine: spheres without walls and gravity, once as dense as a
// packing and at random, as many as the run has, for their contacts are read from memory where a small bed's are in the
// cache; and once in a lattice where none touches any. In LIGGGHTS after the script, with its own units, contact law and
// properties.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "liggghts_fixes/run/resume_point.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Spheres as they are in a script.
struct PlannedSpheres {
  double diameter = 0, density = 0, skin = 0;  ///< means; of the neighbour lists
  int types = 1;
  double number = 0;  ///< of all ranks
};

/// CPU s of a DEM step: of a particle that touches none, and of a contact; of new neighbour lists, of a particle. 0: unknown.
struct ContactCosts {
  double particle = 0, contact = 0, build = 0;
};

/// commands: that the script's scene has been made with; execute: a line. What
/// there was in LIGGGHTS is gone after it. Collective.
ContactCosts contact_costs(LAMMPS_NS::LAMMPS& lammps, const std::vector<Command>& commands,
                           const PlannedSpheres& spheres, const std::function<void(const std::string&)>& execute);

/// Contacts in this rank's lists of LIGGGHTS. Local.
double count_contacts(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
