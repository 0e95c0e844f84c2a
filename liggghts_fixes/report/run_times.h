// Wall clock and CPU time of one run, and what of it the program's parts took.
#pragma once

#include <mpi.h>

#include <string>

#include "coupling/control/stopwatch.h"
#include "coupling/coupling.h"

namespace twogrid {

class RunTimes {
 public:
  /// A run begins at this step; so_far: what the coupling has taken by now.
  void begin(long long step, const Shares& so_far);
  /// Steps of this run, at step number `step`.
  long long done(long long step) const { return step - first_step_; }
  /// Adds the CPU time of its life to the output's share.
  Stopwatch output() { return Stopwatch(output_); }
  double output_seconds() const { return output_; }
  /// Where the run's time went, as a line (progress.h). Collective.
  std::string text(MPI_Comm comm, const Shares& so_far) const;

 private:
  double wall_ = 0, cpu_ = 0;  // when the run began (s)
  long long first_step_ = 0;
  Shares before_;
  double output_ = 0;  // of this run, CPU seconds of this rank
};

}  // namespace twogrid
