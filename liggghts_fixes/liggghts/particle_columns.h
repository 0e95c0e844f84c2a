// LIGGGHTS' particles for the coupling, and columns that LIGGGHTS keeps with every particle: they migrate and restart with
// it.
#pragma once

#include <string>

#include "coupling/particles/particles.h"

namespace LAMMPS_NS {
class FixPropertyAtom;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace twogrid {

struct Motion;

/// A fix property/atom of this name, so many values a particle, all zero at first. A restart file's are taken over.
LAMMPS_NS::FixPropertyAtom* keep_with_particles(LAMMPS_NS::LAMMPS& lammps, const std::string& name, int columns);

/// Collective.
long long particles_of_all_ranks(LAMMPS_NS::LAMMPS& lammps);
/// Of these and of those that have gone, how many the fixes insert/... of the script have made so far. Not collective.
long long inserted_particles(LAMMPS_NS::LAMMPS& lammps);

/// Where the values of a fix property/atom of this name and one column lie now; null: there is none.
double* particle_property(LAMMPS_NS::LAMMPS& lammps, const std::string& name);

/// LIGGGHTS' particles as the coupling sees them, with the columns of kParticleColumns and kStepColumns values. To be made
/// at every call, for LIGGGHTS moves its arrays at any exchange. `watched` is left as it is made.
Particles view_particles(LAMMPS_NS::LAMMPS& lammps, int group, const Motion& motion, LAMMPS_NS::FixPropertyAtom& state,
                         LAMMPS_NS::FixPropertyAtom& step);

}  // namespace twogrid
