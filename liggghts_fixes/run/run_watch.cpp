#include "liggghts_fixes/run/run_watch.h"

#include <atom.h>
#include <comm.h>
#include <lammps.h>
#include <mpi.h>
#include <update.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "liggghts_fixes/liggghts/particle_columns.h"
#include "liggghts_fixes/liggghts/tell.h"
#include "liggghts_fixes/report/status.h"
#include "liggghts_fixes/run/signals.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr double kPatience = 10;  // s that a signal waits for the end of a coupling

}  // namespace

void RunWatch::say(const std::string& text) const {
  tell(lammps_, text);
}

void RunWatch::warn(const std::string& text) const {
  say("WARNING: fix " + id_ + " twogrid: " + text + "\n");
}

void RunWatch::warn_of_news(const std::vector<std::string>& warnings) {
  for (const std::string& w : warnings)
    if (std::find(said_.begin(), said_.end(), w) == said_.end()) {
      warn(w);
      said_.push_back(w);
    }
}

void RunWatch::warn_of_unused_options(const std::string& beginning, const std::string& but) {
  for (const std::string& sentence : unused_options_.sentences(beginning, but)) warn(sentence);
}

void RunWatch::begin_run(long long steps, Schedule& schedule) {
  look(schedule, -1);  // a run that goes on may have to tell of those that vanished before
  progress_.begin(MPI_Wtime(), steps);
}

void RunWatch::look(Schedule& schedule, long long most_lost) const {
  // LIGGGHTS forgets particles that leave by a side in silence.
  const long long now = particles_of_all_ranks(lammps_) - inserted_particles(lammps_);
  const std::string warning = losses(schedule, now, most_lost, lammps_.update->ntimestep);
  if (!warning.empty()) warn(warning);
}

void RunWatch::begin_coupling() {
  coupling_begin_ = MPI_Wtime();
}

void RunWatch::look_within(int steps, double share, double time) {
  const double now = MPI_Wtime(), spent = now - coupling_begin_;
  double most[2] = {double(signal_seen()), spent * (1 - share) / share};
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, lammps_.world);
  if (most[0] > 0 && most[1] > kPatience)
    throw EndedBySignal(int(most[0]), "ended by signal " + std::to_string(int(most[0])) + " within a coupling, after " +
                                          std::to_string(steps) + " of its fluid steps and " + duration(most[1]) +
                                          " before its end: no checkpoint of this step is written, the last one stays; "
                                          "lower every, or raise cfl, for couplings of fewer fluid steps");
  const std::string line = progress_.line_within(now, steps, share, spent, time);
  if (!line.empty()) say(line + "\n");
}

void RunWatch::look(const Report& report, int steps) {
  for (const std::string& sentence : coupling_.look(report, steps, lammps_.update->dt))
    warn(sentence + " (step " + std::to_string(lammps_.update->ntimestep) + ")");
}

void RunWatch::tell_progress(long long done, const Report& report, Schedule& schedule) {
  Status::of_process().couple(lammps_.update->ntimestep, report, schedule.state(), inserted_particles(lammps_));
  const std::string line = progress_.line(MPI_Wtime(), done, report.fluid_time);
  if (!line.empty()) say(line + "\n");
}

}  // namespace twogrid
