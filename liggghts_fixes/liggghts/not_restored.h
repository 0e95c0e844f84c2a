// What LIGGGHTS itself doesn't bring back from a restart file, where a script uses it.
#pragma once

#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// A sentence each; none: nothing. Local.
std::vector<std::string> not_restored(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
