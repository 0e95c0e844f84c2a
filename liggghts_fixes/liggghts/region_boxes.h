// Boxes that a region of LIGGGHTS lies within: of a union those of its parts, so that small parts far from each other are found.
#pragma once

#include <array>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
class Region;
}  // namespace LAMMPS_NS

namespace twogrid {

/// xlo xhi ylo yhi zlo zhi (m) of each; empty: it may be anywhere.
std::vector<std::array<double, 6>> region_boxes(LAMMPS_NS::LAMMPS& lammps, LAMMPS_NS::Region& region);

}  // namespace twogrid
