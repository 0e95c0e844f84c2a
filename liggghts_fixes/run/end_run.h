// The end of a run that failed: one sentence, and no rank left hanging.
#pragma once

#include <mpi.h>

#include <string>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// From here on a sentence with which LIGGGHTS ends by MPI_Abort, which it tells on the screen only, stands in the log,
/// too. With null before lammps is deleted. Local.
void keep_sentences(LAMMPS_NS::LAMMPS* lammps);

/// The screen tells of LIGGGHTS' errors and warnings only. After keep_sentences().
void quieten_screen();

/// To be called with the sentence of an error by every rank that has one. If all ranks arrive here within two seconds,
/// rank 0 says it, on screen and in the log, MPI and PETSc are finalised and the exit code is `code`. Otherwise the error is
/// of some ranks only: each of these says its own sentence and MPI_Abort ends all ranks. comm: one of its own,
/// used for nothing else. lammps may be null.
[[noreturn]] void end_with_error(LAMMPS_NS::LAMMPS* lammps, MPI_Comm comm, const std::string& sentence, int code);

}  // namespace twogrid
