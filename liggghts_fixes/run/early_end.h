// What may end a run before its last step: a signal to any rank, the time for a checkpoint by the clock, or an end that is
// planned within the run. All ranks look together, at the same steps, some five times a second, and whenever an end can have
// come to be planned: such a run always ends at the same step.
#pragma once

#include <mpi.h>

#include <functional>
#include <utility>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class EarlyEnd {
 public:
  explicit EarlyEnd(MPI_Comm comm) : comm_(comm), last_checkpoint_(MPI_Wtime()) {}

  /// Seconds between checkpoints by the clock; 0: none.
  void set_interval(double seconds) { interval_ = seconds; }
  void checkpoint_written() { last_checkpoint_ = MPI_Wtime(), due_ = false; }

  /// What plans ends: steps in which none can come to be planned; steps to the one that is planned, 0: none.
  using Steps = std::function<long long()>;
  void set_plan(Steps undecided, Steps to_end) { undecided_ = std::move(undecided), to_end_ = std::move(to_end); }
  long long steps_undecided() const { return undecided_(); }
  long long steps_to_end() const { return to_end_(); }

  /// DEM steps to the next look; the same on all ranks.
  long long steps_to_look() const { return steps_; }
  /// After `steps` more steps (0: between runs). Whether the run is to end here. Collective.
  bool look(long long steps);
  int signal() const { return signal_; }        ///< that has come to a rank, as of the last look; 0: none
  bool checkpoint_due() const { return due_; }  ///< by the clock, as of the last look

 private:
  static constexpr double kSeconds = 0.2;  ///< between two looks

  MPI_Comm comm_;
  Steps undecided_, to_end_;
  double interval_ = 0, last_checkpoint_ = 0, last_look_ = 0;
  long long steps_ = 1;
  int signal_ = 0;
  bool due_ = false;
};

/// Has LIGGGHTS' time integration (run_style verlet) look during a run. Before the run's init().
void let_runs_end(LAMMPS_NS::LAMMPS& lammps, EarlyEnd& early_end);

}  // namespace twogrid
