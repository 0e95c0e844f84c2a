// Scripts that a fluid beside the particles can't be run with.
#pragma once

#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Throws std::invalid_argument with a sentence. id, style: of the fix that asks.
void refuse_unsupported(LAMMPS_NS::LAMMPS& lammps, const std::string& id, const std::string& style);
/// What can be meant and most likely is not: a sentence each.
std::vector<std::string> doubts(const LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
