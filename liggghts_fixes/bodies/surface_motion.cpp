#include "liggghts_fixes/bodies/surface_motion.h"

#include <fix_mesh_surface.h>
#include <fix_move_mesh.h>
#include <fix_wall_gran.h>
#include <lammps.h>
#include <mesh_mover_rotation.h>
#include <modify.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "liggghts_fixes/private_member.h"

namespace {
using namespace LAMMPS_NS;
using Three = double[3];
PRIVATE_MEMBER(Turns, FixMeshSurface, bool, angVelFlag_);
PRIVATE_MEMBER(MeshVelocity, FixMeshSurface, Three, vSurf_);
PRIVATE_MEMBER(MeshOrigin, FixMeshSurface, Three, origin_);
PRIVATE_MEMBER(MeshAxis, FixMeshSurface, Three, axis_);
PRIVATE_MEMBER(MeshOmega, FixMeshSurface, double, omegaSurf_);
PRIVATE_MEMBER(NameX, FixMeshSurface, char*, vSurfStrX_);
PRIVATE_MEMBER(NameY, FixMeshSurface, char*, vSurfStrY_);
PRIVATE_MEMBER(NameZ, FixMeshSurface, char*, vSurfStrZ_);
PRIVATE_MEMBER(NameOmega, FixMeshSurface, char*, omegaStr_);
PRIVATE_MEMBER(Mover, FixMoveMesh, MeshMover*, move_);
PRIVATE_MEMBER(MoverAxis, MeshMoverRotate, Three, axis_);
PRIVATE_MEMBER(MoverPoint, MeshMoverRotate, Three, point_);
PRIVATE_MEMBER(MoverOmega, MeshMoverRotate, double, omega_);
PRIVATE_MEMBER(Shears, FixWallGran, int, shear_);
PRIVATE_MEMBER(ShearDirection, FixWallGran, int, shearDim_);
PRIVATE_MEMBER(Shear, FixWallGran, double, vshear_);
}  // namespace

namespace twogrid {
namespace {

double size(const Vec3& a) {
  return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

SurfaceMotion turning(const Three& origin, const Three& axis, double omega) {
  SurfaceMotion motion;
  const double length = size({axis[0], axis[1], axis[2]});
  for (int d = 0; d < 3; ++d) motion.origin[d] = origin[d], motion.turning[d] = omega * axis[d] / length;
  return motion;
}

/// A regular polygon of n sides moves through itself by 1.05/n of its velocity in the mean of its triangles, a tilted plane
/// by the tilt; what stands out, such as a blade, by all of it.
bool along_itself(const SurfaceMotion& motion, const std::vector<Triangle>& triangles) {
  constexpr double kThrough = 0.07, kOfOne = 0.35;
  double through = 0, along = 0, fastest = 0, worst = 0;
  for (const Triangle& t : triangles)
    for (const Vec3& corner : t) fastest = std::max(fastest, size(motion.at(corner)));
  for (const Triangle& t : triangles) {
    Vec3 u, v, middle;
    for (int d = 0; d < 3; ++d)
      u[d] = t[1][d] - t[0][d], v[d] = t[2][d] - t[0][d], middle[d] = (t[0][d] + t[1][d] + t[2][d]) / 3;
    const Vec3 area{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]},
        at = motion.at(middle);
    const double speed = size(at), flow = std::abs(at[0] * area[0] + at[1] * area[1] + at[2] * area[2]);
    through += flow, along += speed * size(area);
    if (speed > 0.05 * fastest && size(area) > 0) worst = std::max(worst, flow / (speed * size(area)));
  }
  return through <= kThrough * along && worst <= kOfOne;
}

}  // namespace

FeltMotion surface_motion(FixMeshSurface& mesh, const std::vector<Triangle>& triangles) {
  FeltMotion felt;
  if (!mesh.surfaceVel()) return felt;
  if (mesh.*member(NameX()) || mesh.*member(NameY()) || mesh.*member(NameZ()) || mesh.*member(NameOmega())) {
    felt.why = "by a variable; the fluid takes numbers";
    return felt;
  }
  SurfaceMotion motion;
  if (mesh.*member(Turns()))
    motion = turning(mesh.*member(MeshOrigin()), mesh.*member(MeshAxis()), mesh.*member(MeshOmega()));
  else
    for (int d = 0; d < 3; ++d) motion.velocity[d] = (mesh.*member(MeshVelocity()))[d];
  if (along_itself(motion, triangles))
    felt.motion = motion;
  else
    felt.why = mesh.*member(Turns()) ? "about an axis about which it is not round"
                                     : "in a direction that is not its own everywhere; a belt is a mesh of its flat "
                                       "part, the rest another";
  return felt;
}

FeltMotion mover_motion(LAMMPS& lammps, FixMeshSurface& mesh, const std::vector<Triangle>& triangles) {
  FeltMotion felt;
  Modify& modify = *lammps.modify;
  FixMoveMesh* found = nullptr;
  for (int f = 0; f < modify.nfix; ++f) {
    auto* const mover = dynamic_cast<FixMoveMesh*>(modify.fix[f]);
    if (!mover || !mover->fixMeshCompare(&mesh)) continue;
    if (found) {
      felt.why = "that fixes " + std::string(found->id) + " and " + mover->id + " move";
      return felt;
    }
    found = mover;
  }
  if (!found) {
    const bool by_itself = std::strstr(mesh.style, "6dof") || std::strstr(mesh.style, "servo");
    if (mesh.triMesh()->isMoving() || mesh.triMesh()->isDeforming() || by_itself)
      felt.why = "that moves or deforms (" + std::string(mesh.style) + ")";
    return felt;
  }
  auto* const turns = dynamic_cast<MeshMoverRotate*>(found->*member(Mover()));
  const std::string fix = "that fix " + std::string(found->id) + " " + found->style;
  if (!turns) {
    felt.why = fix + " moves";
    return felt;
  }
  const SurfaceMotion motion =
      turning(turns->*member(MoverPoint()), turns->*member(MoverAxis()), turns->*member(MoverOmega()));
  if (along_itself(motion, triangles))
    felt.motion = motion;
  else
    felt.why = fix + " turns about an axis about which it is not round";
  return felt;
}

FeltMotion shear_motion(FixWallGran& wall, const Primitive& p) {
  FeltMotion felt;
  if (!(wall.*member(Shears()))) return felt;
  const int d = wall.*member(ShearDirection());
  const double number = wall.*member(Shear());
  if (p.cylinder && d != p.axis) {
    // LIGGGHTS takes the grain's z - z0 for x - x0 there and the other way round.
    if (p.axis == 1) {
      felt.why =
          "by 'shear' of a ycylinder, which LIGGGHTS turns with x and z exchanged: the grains feel a velocity "
          "through the wall; a mesh with surface_ang_vel turns rightly";
      return felt;
    }
    felt.motion.turning[p.axis] = number;
    felt.motion.origin[p.axis == 0 ? 1 : 0] = p.value[1], felt.motion.origin[p.axis == 2 ? 1 : 2] = p.value[2];
  } else if (p.cylinder || d != p.axis) {
    felt.motion.velocity[d] = number;
  } else {
    felt.why = "by 'shear' through itself";
  }
  return felt;
}

}  // namespace twogrid
