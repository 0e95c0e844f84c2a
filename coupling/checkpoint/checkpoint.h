// A checkpoint: all that a coupled run hands on to the next one, but for the particles and their columns, which are
// LIGGGHTS' to keep (write_restart). Written between two runs, into one HDF5 file:
//
//   /fluid, /coupling, /schedule   the entries of FluidState, CouplingState, ScheduleState (state_file.h)
//   /output, /averages, /start_up  those of OutputState, AveragesState, StartUpState, where there is output
//   /report and others             entries of Report, and of what the caller lists
//   /record                        step, particles, and what of the settings must be the same: version of this format,
//                                  grids, formulation, models' fields; `every` and the skin, which may have been chosen
//   /ranks                         RankParts
//
// It ends with a line that holds a checksum of all before it (checksum.h): of a damaged file nothing is believed.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "cfd/grid/grid.h"
#include "coupling/checkpoint/rank_parts.h"
#include "coupling/checkpoint/state_file.h"
#include "coupling/settings.h"

namespace twogrid {

class Coupling;
class FluidSolver;
class Output;
struct ScheduleState;

/// What is saved and filled.
struct CheckpointParts {
  MPI_Comm comm;
  const Settings& settings;
  FluidSolver& fluid;
  Coupling& coupling;
  ScheduleState& schedule;
  Output* output;  ///< null: none
  std::vector<NumberList> numbers;
};

/// The step that a checkpoint is of, and the particles of all ranks then.
struct Moment {
  long long step = 0, particles = 0;
};

/// What must be known before fluid and coupling are made.
struct Beginning {
  std::string scene;  ///< in words; read only
  int every = 0;
  Int3 fine{0, 0, 0}, ratio{0, 0, 0};  ///< cells of the grids; read only
  double skin = 0;                     ///< of the neighbour lists, where it was chosen (m); 0: the script's
  RankParts ranks;  ///< of as many ranks as there are now; else not known. Cuts and fluid_brick: written from the fluid
};

/// Between runs, straight into the file of that name. Throws std::runtime_error with a sentence on all ranks.
/// Collective.
void write_plain_checkpoint(const std::string& path, const CheckpointParts& parts, const Moment& now,
                            const Beginning& beginning);
/// The same beside the file of that name, which is then synced and renamed: a file of that name is whole, or it is the
/// one before.
void write_checkpoint(const std::string& path, const CheckpointParts& parts, const Moment& now,
                      const Beginning& beginning);

/// Throws std::runtime_error or std::invalid_argument with a sentence on all ranks where a checkpoint can't be read, is
/// damaged, or belongs to another step or set of particles. Collective.
Beginning read_beginning(MPI_Comm comm, const std::string& path, const Moment& now);
/// Throws where it belongs to another scene. path: for the sentence.
void check_scene(const std::string& path, const Beginning& beginning, const Settings& settings, const FineGrid& grid);
/// Numbers that are needed before the first run's beginning; without them in the file they stay. Collective. Throws likewise.
void read_numbers(MPI_Comm comm, const std::string& path, const Layout& layout, NumberList list);
/// In place of the first run's beginning, after read_beginning(): the parts are as they were when it was written.
/// Collective. Throws likewise.
void read_checkpoint(const std::string& path, const CheckpointParts& parts);

}  // namespace twogrid
