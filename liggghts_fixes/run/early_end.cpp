#include "liggghts_fixes/run/early_end.h"

#include <lammps.h>
#include <modify.h>
#include <output.h>
#include <update.h>
#include <verlet.h>

#include <algorithm>
#include <typeinfo>

#include "liggghts_fixes/report/status.h"
#include "liggghts_fixes/run/signals.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// LIGGGHTS' own loop over the steps, in pieces between two looks.
class WatchedVerlet : public Verlet {
 public:
  WatchedVerlet(LAMMPS* lammps, EarlyEnd& watch) : Verlet(lammps, 0, nullptr), early_end_(watch) {}

  void run(int n) override {
    for (long long done = 0; done < n;) {
      const long long left = n - done, to_end = early_end_.steps_to_end();
      if (to_end > 0 && to_end <= left) return end_after(to_end, done, true);
      const long long piece = std::min({early_end_.steps_to_look(), early_end_.steps_undecided(), left});
      Verlet::run(int(piece));
      done += piece;
      Status::of_process().step(update->ntimestep);
      // One step more, known as the last one: fixes note in it what the next run's set-up reads.
      if (early_end_.look(piece) && done < n) return end_after(1, done, false);
    }
  }

 private:
  /// whole: as at the end of any run, with its last line of thermo.
  void end_after(long long steps, long long done, bool whole) {
    const bigint last = update->laststep = update->ntimestep + steps;
    if (whole) {
      Status::of_process().end_at(last);
      output->next_thermo = std::min(output->next_thermo, last);
      output->next = std::min(output->next, last);
      modify->addstep_compute(last);
    }
    Verlet::run(int(steps));
    update->nsteps = int(done + steps);
  }

  EarlyEnd& early_end_;
};

}  // namespace

bool EarlyEnd::look(long long steps) {
  const double now = MPI_Wtime();
  double most[3] = {double(signal_seen()), steps > 0 ? (now - last_look_) / double(steps) : 0.0, 0.0};
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  if (rank == 0 && interval_ > 0 && now - last_checkpoint_ >= interval_) most[2] = 1;
  MPI_Allreduce(MPI_IN_PLACE, most, 3, MPI_DOUBLE, MPI_MAX, comm_);
  last_look_ = now;
  // A step may come to cost much more than those before it, above all in another run.
  const double by_cost = kSeconds / std::max(most[1], 1e-9);
  steps_ = steps > 0 ? (long long)(std::clamp(by_cost, 1.0, 10.0 * double(steps))) : 1;
  signal_ = int(most[0]);
  due_ = most[2] > 0;
  return signal_ != 0 || due_;
}

void let_runs_end(LAMMPS& lammps, EarlyEnd& watch) {
  Integrate*& integrate = lammps.update->integrate;
  if (!integrate || typeid(*integrate) != typeid(Verlet)) return;
  delete integrate;
  integrate = new WatchedVerlet(&lammps, watch);
}

}  // namespace twogrid
