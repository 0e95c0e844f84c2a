// Reads out of LIGGGHTS what the scene report needs, so that no script has to say it twice.
#pragma once

#include <vector>

#include "coupling/particles/particles.h"
#include "liggghts_fixes/report/scene_report.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// What fixes gravity do to the particles of their groups. LIGGGHTS asks variables when it evaluates forces: before, in
/// a run's initialisation, fixes that follow one are left out (running = false).
std::vector<Weight> find_weights(LAMMPS_NS::LAMMPS& lammps, bool running);
/// Whether one of them follows a variable. Known from initialisation on.
bool weights_vary(LAMMPS_NS::LAMMPS& lammps);

/// Particles of the group, gravity, walls, contact time, ranks. Collective.
SceneFacts scene_facts(LAMMPS_NS::LAMMPS& lammps, int groupbit);

}  // namespace twogrid
