// What LIGGGHTS' own output has written before a checkpoint, when another process goes on from it.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Dumps into one file go on in it, after the frames up to the present step; later ones, of the run that ended behind its
/// last checkpoint, are taken off. The frame of the present step is not written twice. Between the dump commands and
/// the run. Collective.
void go_on_with_dumps(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
