// LIGGGHTS' part in how a checkpoint's particles were shared out over the ranks (coupling/checkpoint/rank_parts.h).
// read_restart cuts the box into equal parts and takes particles as they come; sums, such as a particle's contact
// forces, go by the order in memory.
#pragma once

#include "coupling/checkpoint/rank_parts.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// As it is now, but for the fluid's cells.
RankParts rank_parts(LAMMPS_NS::LAMMPS& lammps);
/// Between LIGGGHTS' ranks, before a run is set up: borders as they were. False, and nothing is done: there are as many
/// ranks, but in other bricks. Collective.
bool restore_borders(LAMMPS_NS::LAMMPS& lammps, const RankParts& parts);
/// In a run's set-up, before particles are exchanged: every rank gets the particles that it had, in the order in memory
/// that they had; what fixes keep of them goes with them. Throws std::invalid_argument on all ranks where these are not
/// the particles that there are. Collective.
void restore_order(LAMMPS_NS::LAMMPS& lammps, const RankParts& parts);

}  // namespace twogrid
