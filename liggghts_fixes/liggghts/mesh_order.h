// The order of a mesh's triangles on a rank. LIGGGHTS sums a grain's forces by it, and it hangs on the past: on the
// borders of the first run, on which triangles have come and gone since, on the ranks that wrote a restart file.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// In a run's set-up, when particles and borders are in place, on several ranks: triangles of all meshes that are shared out go to
/// their ranks and lie there by their IDs, so that forces hang on the borders alone. LIGGGHTS then makes the ghosts from them.
/// Collective.
void order_meshes(LAMMPS_NS::LAMMPS& lammps);

/// In the same place, of a run that goes on from a restart file, which has meshes where they were, but at rest: forces at its
/// beginning are to see the velocities of fix move/mesh.
void find_mesh_velocities(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
