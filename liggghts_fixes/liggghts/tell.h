// What a user is told: on LIGGGHTS' screen and in its log.
#pragma once

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// By rank 0; the text as it is, with its line's end. At once, for a run may not end well. Local.
void tell(LAMMPS_NS::LAMMPS& lammps, const std::string& text);

}  // namespace twogrid
