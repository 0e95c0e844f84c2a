// One process's work on one script: reads it, cuts its runs where checkpoints are due, writes them, ends at signals, and
// goes on from a checkpoint of another process.
#pragma once

#include <mpi.h>

#include <optional>
#include <string>

#include "liggghts_fixes/run/checkpoint_folder.h"
#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/run/early_end.h"
#include "liggghts_fixes/run/interpreter.h"
#include "liggghts_fixes/run/planner.h"
#include "liggghts_fixes/run/run_request.h"
#include "liggghts_fixes/script/script.h"

namespace twogrid {

class Session {
 public:
  /// line: as it was given. from: what to go on from; its path empty: begin. Collective.
  Session(LAMMPS_NS::LAMMPS& lammps, const CommandLine& line, Checkpoint from);

  /// Executes the script, or the rest of it. Returns the number of the signal that ended it, or 0. Collective.
  int run();

  /// A command `run` or `run_time`, with its name.
  void run_command(const Command& words);

 private:
  void go_on();
  void run_parts(const Command& words, const RunRequest& request);
  void plan_parts(const Command& words, const RunRequest& request);
  bool end_here();
  bool end_reached(bool at_its_own) const;
  long long part_to(const RunRequest& r, long long step) const;
  CheckpointPlan plan() const;
  CheckpointFolder folder() const;
  void try_folder() const;
  void write_checkpoint(const Command& words, const RunRequest& request);

  LAMMPS_NS::LAMMPS& lammps_;
  Interpreter interpreter_;
  std::optional<Planner> planner_;  // of a script that is only planned
  EarlyEnd early_end_;
  Checkpoint from_;
  bool limits_said_ = false;  // what LIGGGHTS doesn't restore
  bool ended_ = false;        // by a signal; what there was to keep is kept
};

/// What the command line's -restart asks for; path empty: nothing, or nothing is there (auto). Throws
/// std::invalid_argument with a sentence where a checkpoint was named and none is whole. Collective.
Checkpoint checkpoint_wanted(MPI_Comm comm, const CommandLine& line);
}  // namespace twogrid
