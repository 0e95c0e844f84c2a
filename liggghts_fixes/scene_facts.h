// Reads out of LIGGGHTS what the scene report needs, so that no script has to say it twice.
#pragma once

#include "scene_report.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Particles of the group, gravity, walls, contact time, ranks. Collective.
SceneFacts scene_facts(LAMMPS_NS::LAMMPS& lammps, int groupbit);

}  // namespace twogrid
