// The box, and how LIGGGHTS shares it and its particles out over ranks.
#pragma once

#include <string>

#include "cfd/grid/layout.h"
#include "coupling/two_grid/window.h"
#include "liggghts_fixes/script/script.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

struct SceneFacts;

BoxFacts box_facts(LAMMPS_NS::LAMMPS& lammps);
/// The fluid's grid was made for a box; it can't follow another. Throws std::invalid_argument. id: of the fix.
void check_box(LAMMPS_NS::LAMMPS& lammps, const BoxFacts& made_for, const std::string& id);
/// The fluid's bricks: where LIGGGHTS' are, to the particle cell, or its own (fluid_layout.h).
Layout fluid_layout(LAMMPS_NS::LAMMPS& lammps, const FineGrid& grid, const Int3& ratio);
/// Whether LIGGGHTS looks at every step if its neighbour lists still hold.
bool prompt_lists(LAMMPS_NS::LAMMPS& lammps);
/// The rank's part of the box, and how far outside it a particle may lie: LIGGGHTS exchanges particles when one has moved
/// half a skin. Where it may look late (neigh_modify delay or every), a whole skin.
ParticleRegion particle_region(LAMMPS_NS::LAMMPS& lammps);

/// -skin best: a skin for particles as large as these, unless the script's is near it. Before LIGGGHTS sets up its
/// neighbour lists; meshes have read the skin already. Returns the one chosen (m), which facts have now; 0: none.
double choose_skin(LAMMPS_NS::LAMMPS& lammps, SceneFacts& facts);

}  // namespace twogrid
