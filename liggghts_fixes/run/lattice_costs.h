// What a contact of a script's contact law costs on this machine: two lattices of spheres without walls and gravity, one in
// which each touches six others, one in which none touches any, in LIGGGHTS after the script, with its own units, contact
// law and properties.
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
};

/// CPU s of a DEM step: of a particle that touches none, and of a contact; 0: unknown.
struct LatticeCosts {
  double particle = 0, contact = 0;
};

/// commands: that the script's scene has been made with; execute: a line. What
/// there was in LIGGGHTS is gone after it. Collective.
LatticeCosts lattice_costs(LAMMPS_NS::LAMMPS& lammps, const std::vector<Command>& commands,
                           const PlannedSpheres& spheres, const std::function<void(const std::string&)>& execute);

/// Contacts in this rank's lists of LIGGGHTS. Local.
double count_contacts(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
