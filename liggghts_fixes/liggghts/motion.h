// What LIGGGHTS' fixes do to positions and velocities: which particles move, and which of them the fluid can push.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/liggghts/motion_kind.h"

namespace LAMMPS_NS {
class Fix;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace twogrid {

/// Group bits, as Particles wants them.
struct Motion {
  int moving[3] = {0, 0, 0}, fixed[3] = {0, 0, 0}, frozen[3] = {0, 0, 0};
  bool still = true;                  ///< nothing moves particles, or changes their size
  bool grows = false;                 ///< a fix changes diameters during the run
  std::vector<std::string> warnings;  ///< one sentence each
};

/// Of the fixes as they are now; `coupled` is the one whose forces are the fluid's. What overwrites forces holds
/// against the fluid wherever it stands. Throws std::invalid_argument with a sentence for what can't be served.
Motion find_motion(LAMMPS_NS::LAMMPS& lammps, const LAMMPS_NS::Fix& coupled);

}  // namespace twogrid
