// What the output files keep of the run that wrote them.
#pragma once

#include "coupling/output/output.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

Record run_record(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
