#include "liggghts_fixes/run/planner.h"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>
#include <mpi.h>
#include <neighbor.h>
#include <output.h>
#include <update.h>
#include <verlet.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <typeinfo>

#include "coupling/control/stopwatch.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/insertion_to_come.h"
#include "liggghts_fixes/liggghts/particle_columns.h"
#include "liggghts_fixes/liggghts/scene_facts.h"
#include "liggghts_fixes/liggghts/tell.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/run/still_files.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr double kLeast = 0.0025, kMost = 0.1;  // of the time to measure, for a run

std::vector<FixTwogrid*> fluids(LAMMPS& lammps) {
  std::vector<FixTwogrid*> found;
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* f = dynamic_cast<FixTwogrid*>(lammps.modify->fix[i])) found.push_back(f);
  return found;
}

class MeasuredVerlet : public Verlet {
 public:
  MeasuredVerlet(LAMMPS* lammps, Planner& planner) : Verlet(lammps, 0, nullptr), planner_(planner) {}

  void run(int n) override {
    const bigint first = update->ntimestep;
    planner_.measure(
        n, [&](int steps) { Verlet::run(steps); },
        [&](int steps) {
          const bigint last = update->laststep = update->ntimestep + steps;
          output->next_thermo = std::min(output->next_thermo, last);
          output->next = std::min(output->next, last);
          modify->addstep_compute(last);
          Verlet::run(steps);
          update->nsteps = int(update->ntimestep - first);
        });
  }

 private:
  Planner& planner_;
};

/// Largest memory that this process has had (bytes).
double most_memory() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    double kilobytes = 0;
    if (words >> name >> kilobytes && name == "VmHWM:") return 1024 * kilobytes;
  }
  return 0;
}

}  // namespace

Planner::Planner(LAMMPS& lammps, const std::string& script, double seconds)
    : lammps_(lammps), seconds_(seconds), files_(lammps) {
  plan_.script = script.empty() ? "the standard input" : script;
  plan_.ranks = lammps.comm->nprocs;
  plan_.empty_bytes = most_of_ranks(most_memory());
  began_ = MPI_Wtime();
  between_ = cpu_seconds();
}

double Planner::most_of_ranks(double value) const {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, lammps_.world);
  return value;
}

void Planner::let_runs_be_measured() {
  Integrate*& integrate = lammps_.update->integrate;
  if (!integrate || typeid(*integrate) != typeid(Verlet)) return;
  delete integrate;
  integrate = new MeasuredVerlet(&lammps_, *this);
}

Planner::Times Planner::now() const {
  Times t;
  t.cpu = cpu_seconds();
  t.step = lammps_.update->ntimestep;
  for (const FixTwogrid* f : fluids(lammps_)) {
    const Shares s = f->shares();
    t.deposit += s.deposit, t.map += s.map, t.fluid += s.fluid, t.output += s.output;
    t.fluid_steps += f->fluid_steps();
  }
  return t;
}

/// DEM steps after which all that a run does has been done.
int Planner::interval() const {
  int steps = 1;
  for (const FixTwogrid* f : fluids(lammps_)) steps = std::max(steps, f->settings().every);
  return steps;
}

void Planner::measure(int n, const Steps& advance, const Steps& end) {
  const double wanted = std::clamp((seconds_ - spent_) / 4, kLeast * seconds_, kMost * seconds_),
               begin = most_of_ranks(MPI_Wtime());
  const int interval = this->interval();
  int left = n - 1;
  const auto spent = [&] { return most_of_ranks(MPI_Wtime()) - begin; };
  const auto make = [&](long long steps) {
    const int m = int(std::min<long long>(steps, left));
    advance(m);
    left -= m;
  };
  loop_ = from_ = now();
  // To a coupling, and on until all is in the caches and the flow has begun.
  for (int i = 0; left > 0 && (i < 3 || spent() < 0.3 * wanted); ++i)
    make(i == 0 ? interval - lammps_.update->ntimestep % interval : interval);
  if (left > 0) from_ = now();
  const double measured_from = spent();
  for (long long steps = interval; left > 0;) {
    const double before = spent();
    if (before - measured_from > wanted) break;
    make(steps);
    if (spent() - before < 0.05 * wanted) steps *= 2;
  }
  to_ = now();
  files_.ask_dumps();
  if (n > 0) end(1);
  end_ = now();
  spent_ += spent();
}

void Planner::begin_run(const std::string& line) {
  PlannedRun run;
  run.line = line;
  plan_.runs.push_back(run);
}

void Planner::begin_part() {
  part_ = now();
  plan_.setup_seconds += most_of_ranks(part_.cpu - between_);
}

void Planner::end_part(long long to, const std::vector<Command>& commands) {
  PlannedRun& run = plan_.runs.back();
  Update& update = *lammps_.update;
  const long long left = to - update.ntimestep;
  run.steps += to - part_.step;

  // What has been done, and what is left at the speed that was measured.
  const Times after = now();
  const double steps = double(std::max(1LL, to_.step - from_.step)), times = double(left) / steps;
  const auto whole = [&](double Times::*part) { return end_.*part - loop_.*part + times * (to_.*part - from_.*part); };
  const double cpu = whole(&Times::cpu), fluid = whole(&Times::fluid) + 0.5 * whole(&Times::map),
               output = whole(&Times::output);
  const double present = double(particles_of_all_ranks(lammps_));
  const ComingParticles coming = pass_insertions(lammps_, to);
  const double here = present + coming_ + 0.5 * coming.number;  // on average
  coming_ += coming.number;
  run.particle_seconds += most_of_ranks(std::max(0.0, cpu - fluid - output)) * (present > 0 ? here / present : 1.0);
  run.fluid_seconds += most_of_ranks(fluid);
  run.other_seconds += most_of_ranks(output + (after.cpu - part_.cpu) - (end_.cpu - loop_.cpu));
  run.fluid_steps += double(end_.fluid_steps - loop_.fluid_steps) + times * double(to_.fluid_steps - from_.fluid_steps);
  run.particles = present + coming_;
  if (coming.at_most)
    plan_.remarks.push_back("run " + std::to_string(plan_.runs.size()) +
                            " fills a region again and again: its particles are the most that there can be");

  // On to its end.
  if (left > 0) {
    update.update_time();
    update.atime += double(left) * update.dt;
    update.ntimestep = update.atimestep = to;
    for (int i = 0; i < lammps_.modify->nfix; ++i) {
      bigint& next = lammps_.modify->fix[i]->next_reneighbor;
      if (next > 0 && next <= to) next = to + 1;
    }
    for (FixTwogrid* f : fluids(lammps_)) f->pass(left);
  }
  files_.measure_dumps();
  files_.count(part_.step, to, commands);
  run.other_seconds += most_of_ranks(files_.take_seconds());
  between_ = cpu_seconds();
}

void Planner::end_run() {
  PlannedRun& run = plan_.runs.back();
  for (const FixTwogrid* f : fluids(lammps_)) {
    run.couplings = std::max(run.couplings, double(run.steps) / f->settings().every);
    run.at_most = run.at_most || f->settings().output.until > 0;
  }
  take_scene(run);
  between_ = cpu_seconds();
}

void Planner::take_scene(PlannedRun& run) {
  const Domain& domain = *lammps_.domain;
  PlannedParts& parts = run.parts;
  run.reach = lammps_.neighbor->cutneighmax;
  double lo[3], hi[3], volume = 0;
  for (int d = 0; d < 3; ++d) {
    parts.bricks[d] = lammps_.comm->procgrid[d], parts.wanted[d] = lammps_.comm->user_procgrid[d];
    parts.length[d] = domain.prd[d];
    lo[d] = domain.boxhi[d], hi[d] = domain.boxlo[d];
  }
  const Atom& atom = *lammps_.atom;
  for (int i = 0; i < atom.nlocal; ++i) {
    for (int d = 0; d < 3; ++d) lo[d] = std::min(lo[d], atom.x[i][d]), hi[d] = std::max(hi[d], atom.x[i][d]);
    if (atom.radius) volume += 4.0 / 3 * 3.14159265358979 * atom.radius[i] * atom.radius[i] * atom.radius[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, lo, 3, MPI_DOUBLE, MPI_MIN, lammps_.world);
  MPI_Allreduce(MPI_IN_PLACE, hi, 3, MPI_DOUBLE, MPI_MAX, lammps_.world);
  MPI_Allreduce(MPI_IN_PLACE, &volume, 1, MPI_DOUBLE, MPI_SUM, lammps_.world);
  if (volume <= 0) return;
  for (int d = 0; d < 3; ++d)
    parts.lo[d] = (lo[d] - domain.boxlo[d]) / domain.prd[d], parts.hi[d] = (hi[d] - domain.boxlo[d]) / domain.prd[d];
  // What falls will lie at the bottom.
  Vec3 g{0, 0, 0};
  for (const Weight& w : find_weights(lammps_, false))
    for (int d = 0; d < 3; ++d) g[d] += w.g[d];
  int along = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(g[d]) > std::abs(g[along])) along = d;
  if (g[along] != 0 && !domain.periodicity[along]) {
    double section = 1;
    for (int d = 0; d < 3; ++d)
      if (d != along) section *= hi[d] - lo[d];
    const double height = 1.2 * volume / 0.6 / std::max(section, 1e-300) / domain.prd[along];
    if (g[along] < 0)
      parts.hi[along] = std::min(parts.hi[along], parts.lo[along] + height);
    else
      parts.lo[along] = std::max(parts.lo[along], parts.hi[along] - height);
  }
  for (const FixTwogrid* f : fluids(lammps_)) {
    const Int3& n = f->settings().fine;
    run.cells = double(n[0]) * n[1] * n[2];
    parts.follow = f->borders_follow();
  }
}

bool Planner::has_enough() const {
  constexpr double kSeconds = 60;
  return most_of_ranks(MPI_Wtime()) - began_ > kSeconds && plan_.runs.size() > 100;
}

void Planner::finish(bool stopped) {
  plan_.setup_seconds += most_of_ranks(cpu_seconds() - between_);
  plan_.most_bytes = most_of_ranks(most_memory());
  if (stopped)
    plan_.remarks.push_back(
        "the script hasn't come to its end after " + std::to_string(plan_.runs.size()) +
        " runs: a loop waits for a result, which a plan doesn't have; all figures are of the runs so far");
  plan_.files = files_.list();
  tell(lammps_, plan_text(plan_));
}

}  // namespace twogrid
