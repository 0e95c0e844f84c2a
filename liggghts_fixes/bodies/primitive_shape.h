// The plane or cylinder of a fix wall/gran primitive.
#pragma once

#include <array>
#include <memory>

#include "cfd/bodies/solid_shape.h"

namespace LAMMPS_NS {
class FixWallGran;
}

namespace twogrid {

struct Primitive {
  int axis = 0;  ///< a plane's normal, or a cylinder's axis
  bool cylinder = false;
  /// Plane: position (m). Cylinder: radius and its axis' coordinates in the other two directions, ascending (m).
  std::array<double, 3> value{0, 0, 0};
};

Primitive primitive_of(LAMMPS_NS::FixWallGran& wall);
/// Which side the fluid is on it doesn't know.
std::shared_ptr<const SolidShape> primitive_shape(const Primitive& primitive);

}  // namespace twogrid
