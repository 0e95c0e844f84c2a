#include "liggghts_fixes/bodies/primitive_shape.h"

#include <fix_wall_gran.h>
#include <primitive_wall.h>

#include <stdexcept>

#include "cfd/bodies/simple_shapes.h"
#include "liggghts_fixes/private_member.h"

namespace {
using LAMMPS_NS::PrimitiveWall;
PRIVATE_MEMBER(WallStyle, PrimitiveWall, LAMMPS_NS::PRIMITIVE_WALL_DEFINITIONS::WallType, wType);
PRIVATE_MEMBER(WallNumbers, PrimitiveWall, double*, param);
}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

Primitive primitive_of(FixWallGran& wall) {
  PrimitiveWall* const p = wall.primitiveWall();
  if (!p) throw std::invalid_argument("fix " + std::string(wall.id) + " wall/gran has neither meshes nor a primitive");
  const int style = p->*member(WallStyle());
  const double* const numbers = p->*member(WallNumbers());
  Primitive found;
  found.cylinder = style >= PRIMITIVE_WALL_DEFINITIONS::XCYLINDER;
  found.axis = style % 3;
  found.value[0] = numbers[0];
  if (!found.cylinder) return found;
  // LIGGGHTS gives the axis' coordinates in cyclic order: z and x for a cylinder along y.
  const bool turned = found.axis == 1;
  found.value[1] = numbers[turned ? 2 : 1], found.value[2] = numbers[turned ? 1 : 2];
  return found;
}

std::shared_ptr<const SolidShape> primitive_shape(const Primitive& p) {
  Vec3 point{0, 0, 0}, axis{0, 0, 0};
  axis[p.axis] = 1;
  if (!p.cylinder) {
    point[p.axis] = p.value[0];
    return std::make_shared<PlaneShape>(point, axis, false);
  }
  point[p.axis == 0 ? 1 : 0] = p.value[1], point[p.axis == 2 ? 1 : 2] = p.value[2];
  return std::make_shared<CylinderShape>(point, axis, p.value[0]);
}

}  // namespace twogrid
