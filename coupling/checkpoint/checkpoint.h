// A checkpoint: all that a coupled run hands on to the next one, but for the particles and their columns, which are
// LIGGGHTS' to keep (write_restart). Written between two runs, into one HDF5 file:
//
//   /fluid, /coupling, /schedule   the entries of FluidState, CouplingState, ScheduleState (state_file.h)
//   /record                        step, particles, and what of the settings must be the same: version of this format,
//                                  grids, formulation, models' fields
//
// It is written beside the file of that name, synced, and renamed: a file of that name is whole, or it is the one before.
#pragma once

#include <mpi.h>

#include <string>

#include "coupling/settings.h"

namespace twogrid {

class Coupling;
class FluidSolver;
struct ScheduleState;

/// What is saved and filled.
struct CheckpointParts {
  MPI_Comm comm;
  Settings& settings;  ///< `every` is part of it
  FluidSolver& fluid;
  Coupling& coupling;
  ScheduleState& schedule;
};

/// Between runs. step, particles: of now, all ranks. Throws std::runtime_error with a sentence on all ranks; a file of
/// that name is then as it was. Collective.
void write_checkpoint(const std::string& path, const CheckpointParts& parts, long long step, long long particles);
/// The same, straight into the file of that name, neither synced nor renamed.
void write_plain_checkpoint(const std::string& path, const CheckpointParts& parts, long long step, long long particles);
/// In place of the first run's beginning: the parts are as they were when it was written. Throws std::runtime_error or
/// std::invalid_argument with a sentence on all ranks where it can't be read, or belongs to another scene, step or set of
/// particles. Collective.
void read_checkpoint(const std::string& path, const CheckpointParts& parts, long long step, long long particles);

}  // namespace twogrid
