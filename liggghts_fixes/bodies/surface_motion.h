// Walls of LIGGGHTS that move along themselves: surface_vel and surface_ang_vel of a mesh, shear of a primitive, fix
// move/mesh rotate of a mesh that is round about its axis. The fluid is to feel what the grains feel.
#pragma once

#include <string>
#include <vector>

#include "cfd/bodies/triangle_set.h"
#include "liggghts_fixes/bodies/primitive_shape.h"

namespace LAMMPS_NS {
class FixMeshSurface;
class FixWallGran;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace twogrid {

struct FeltMotion {
  SurfaceMotion motion;  ///< at rest where the fluid can't follow
  std::string why;       ///< why it can't; the grains feel more
};

/// surface_vel, surface_ang_vel. triangles: the mesh's.
FeltMotion surface_motion(LAMMPS_NS::FixMeshSurface& mesh, const std::vector<Triangle>& triangles);
/// Of the one fix move/mesh rotate that moves it; with a reason where it is another mover, or takes the surface away from
/// where it is.
FeltMotion mover_motion(LAMMPS_NS::LAMMPS& lammps, LAMMPS_NS::FixMeshSurface& mesh,
                        const std::vector<Triangle>& triangles);
/// shear. Of a cylinder across its axis LIGGGHTS takes the number for a turning (rad/s).
FeltMotion shear_motion(LAMMPS_NS::FixWallGran& wall, const Primitive& primitive);

}  // namespace twogrid
