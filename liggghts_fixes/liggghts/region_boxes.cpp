#include "liggghts_fixes/liggghts/region_boxes.h"

#include <domain.h>
#include <lammps.h>
#include <region.h>
#include <region_union.h>

#include "liggghts_fixes/private_member.h"

namespace {
PRIVATE_MEMBER(PartCount, LAMMPS_NS::RegUnion, int, nregion);
PRIVATE_MEMBER(PartList, LAMMPS_NS::RegUnion, int*, list);
}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// False: it has none.
bool add_boxes(LAMMPS& lammps, Region& r, std::vector<std::array<double, 6>>& boxes) {
  if (!r.interior || r.varshape || r.dynamic_check()) return false;  // LIGGGHTS keeps the box of where a region began
  if (auto* u = dynamic_cast<RegUnion*>(&r)) {
    for (int i = 0; i < u->*member(PartCount()); ++i)
      if (!add_boxes(lammps, *lammps.domain->regions[(u->*member(PartList()))[i]], boxes)) return false;
    return true;
  }
  if (!r.bboxflag) return false;
  boxes.push_back({r.extent_xlo, r.extent_xhi, r.extent_ylo, r.extent_yhi, r.extent_zlo, r.extent_zhi});
  return true;
}

}  // namespace

std::vector<std::array<double, 6>> region_boxes(LAMMPS& lammps, Region& region) {
  std::vector<std::array<double, 6>> boxes;
  if (!add_boxes(lammps, region, boxes)) boxes.clear();
  return boxes;
}

}  // namespace twogrid
