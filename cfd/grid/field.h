// Fields on a grid: values of the rank's own cells or faces and of a halo around them.
#pragma once

#include <array>

#include "cfd/grid/box.h"
#include "cfd/grid/grid.h"

namespace twogrid {

/// One value a cell of grid type G. Indices are global; the array covers the rank's own cells and the halo.
template <class G>
struct CellField : Array3<double> {
  using Array3<double>::Array3;
};

/// One value a face normal to one direction d of grid type G. Face (i,j,k) is the LOW face of cell (i,j,k) in d; in a
/// direction that is not periodic, index n is the high boundary face, owned by the last rank.
template <class G>
struct FaceComponent : Array3<double> {
  using Array3<double>::Array3;
};

/// Three face components: a velocity, a flux, a face coefficient.
template <class G>
using FaceField = std::array<FaceComponent<G>, 3>;

}  // namespace twogrid
