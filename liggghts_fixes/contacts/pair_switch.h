// Whether the steps of a run evaluate contacts: LIGGGHTS decides it once per run, a fixed bed may do with less.
#pragma once

namespace LAMMPS_NS {
class Integrate;
}

namespace twogrid {

/// From this step on: contacts are skipped, or evaluated as at the run's beginning (if there is a pair style).
void skip_pair(LAMMPS_NS::Integrate& integrate, bool skip, bool has_pair);

}  // namespace twogrid
