// A surface of triangles, of any orientation, closed or not.
#pragma once

#include <array>
#include <vector>

#include "cfd/bodies/solid_shape.h"

namespace twogrid {

using Triangle = std::array<Vec3, 3>;

}  // namespace twogrid
