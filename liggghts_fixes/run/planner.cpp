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
#include "liggghts_fixes/report/planned_bed.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/run/still_files.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr double kSome = 500;                   // particles, from which on their work can be told from the step's
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
    : lammps_(lammps), seconds_(seconds), files_(lammps, script) {
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
  t.builds = lammps_.neighbor->ncalls;
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
  // In the middle of the run, at a step at which all that looks at one in so many steps looks.
  const long long first = lammps_.update->ntimestep, raster = 100LL * interval;
  look_ahead(first + (part_end_ - first) / 2 / raster * raster);
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
  look_at_bed();
  look_ahead(0);
  files_.ask_dumps();
  if (n > 0) end(1);
  end_ = now();
  spent_ += spent();
}

void Planner::look_ahead(long long step) {
  for (FixTwogrid* f : fluids(lammps_)) f->look_ahead(step);
}

void Planner::look_at_bed() {
  bed_ = {};
  for (FixTwogrid* f : fluids(lammps_))
    if (const PlannedBed b = f->planned_bed(); b.share > bed_.share) bed_ = b;
  contacts_ = count_contacts(lammps_);
}

void Planner::begin_run(const std::string& line) {
  PlannedRun run;
  run.line = line;
  plan_.runs.push_back(run);
  missing_.push_back({});
}

void Planner::begin_part(long long to) {
  if (!lammps_.update->first_update) {  // of a scene
    coming_ = fallen_ = particles_ = 0;
    stale_ = false;
  }
  part_ = now();
  part_end_ = to;
  insertions_ = last_insertions(lammps_, to);
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
  // Particles hang where they would have fallen, and there is no room for others: these come at once, the rest by and by.
  if (stale_) coming_ += without_room(lammps_, insertions_);
  const double here = present + coming_ + 0.5 * coming.number;  // on average
  coming_ += coming.number;
  stale_ = stale_ || (left > 0 && present > 0);
  const bool some = present >= kSome;  // else the particles that there will be are thought of as in a lattice
  run.particle_seconds += most_of_ranks(std::max(0.0, cpu - fluid - output)) * (some ? here / present : 1.0);
  if (!some) missing_.back().particles += (here - present) / plan_.ranks * double(to - part_.step);
  run.fluid_seconds += most_of_ranks(fluid);
  run.other_seconds += most_of_ranks(output + (after.cpu - part_.cpu) - (end_.cpu - loop_.cpu));
  run.fluid_steps += double(end_.fluid_steps - loop_.fluid_steps) + times * double(to_.fluid_steps - from_.fluid_steps);
  run.particles = present + coming_;
  const double run_seconds = double(to - part_.step) * update.dt;
  if (run.particles > particles_) fallen_ = 0;
  particles_ = run.particles;
  take_scene(run);
  double contacts = contacts_;
  MPI_Allreduce(MPI_IN_PLACE, &contacts, 1, MPI_DOUBLE, MPI_SUM, lammps_.world);
  bool still = false;
  for (const FixTwogrid* f : fluids(lammps_)) still = still || f->nothing_moves();
  if (here > 0 && fall_ >= 0 && !still && to > part_.step + 1) {
    const double measured = present > 0 ? contacts / present : 0.0;
    // In a fluid at rest they sink more slowly; scripts let them settle, and mostly not much longer.
    const double falls = fluids(lammps_).empty() ? fall_ - fallen_ : 0.5 * run_seconds;
    const double wanted = planned_contacts(bed_.share, measured, falls, run_seconds);
    const double work = here * fullest_share(run.parts, plan_.ranks) * double(to - part_.step);
    missing_.back().contacts += (wanted - measured) * work;
    const double builds =
        planned_builds(bed_, lammps_.neighbor->skin, update.dt) - double(to_.builds - from_.builds) / steps;
    missing_.back().builds += std::max(0.0, builds) * work;
  }
  fallen_ += run_seconds;
  scene_ = commands;
  if (coming.at_most)
    plan_.remarks.push_back("run " + std::to_string(plan_.runs.size()) +
                            " fills a region again and again: its particles are the most that there can be");

  // On to its end.
  if (left > 0) {
    update.update_time();
    update.atime += double(left) * update.dt;
    update.ntimestep = update.atimestep = to;
    for (int i = 0; i < lammps_.modify->nfix; ++i) {
      if (!lammps_.modify->fix[i]->force_reneighbor) continue;  // LIGGGHTS leaves theirs unset
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
  between_ = cpu_seconds();
}

void Planner::take_scene(PlannedRun& run) {
  const Domain& domain = *lammps_.domain;
  PlannedParts& parts = run.parts;
  run.reach = lammps_.neighbor->cutneighmax;
  double lo[3], hi[3], sums[3] = {0, 0, 0};  // volume, radius, mass
  double& volume = sums[0];
  for (int d = 0; d < 3; ++d) {
    parts.bricks[d] = lammps_.comm->procgrid[d], parts.wanted[d] = lammps_.comm->user_procgrid[d];
    parts.length[d] = domain.prd[d];
    lo[d] = domain.boxhi[d], hi[d] = domain.boxlo[d];
  }
  const Atom& atom = *lammps_.atom;
  for (int i = 0; i < atom.nlocal; ++i) {
    for (int d = 0; d < 3; ++d) lo[d] = std::min(lo[d], atom.x[i][d]), hi[d] = std::max(hi[d], atom.x[i][d]);
    if (!atom.radius || !atom.rmass) continue;
    volume += 4.0 / 3 * 3.14159265358979 * atom.radius[i] * atom.radius[i] * atom.radius[i];
    sums[1] += atom.radius[i], sums[2] += atom.rmass[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, lo, 3, MPI_DOUBLE, MPI_MIN, lammps_.world);
  MPI_Allreduce(MPI_IN_PLACE, hi, 3, MPI_DOUBLE, MPI_MAX, lammps_.world);
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, lammps_.world);
  fall_ = -1;
  if (volume <= 0) return;
  spheres_ = {2 * sums[1] / double(particles_of_all_ranks(lammps_)), sums[2] / volume, lammps_.neighbor->skin,
              atom.ntypes, std::max(spheres_.number, particles_)};
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
    const double settled = volume / 0.6 / std::max(section, 1e-300);
    const double height = 1.2 * settled / domain.prd[along];
    fall_ = std::sqrt(2 * std::max(0.0, hi[along] - lo[along] - settled) / std::abs(g[along]));
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

void Planner::finish(bool stopped, const std::function<void(const std::string&)>& execute) {
  plan_.setup_seconds += most_of_ranks(cpu_seconds() - between_);
  plan_.most_bytes = most_of_ranks(most_memory());
  plan_.files = files_.list();
  const ContactCosts cost = contact_costs(lammps_, scene_, spheres_, execute);
  for (std::size_t i = 0; i < missing_.size(); ++i) {
    double& seconds = plan_.runs[i].particle_seconds;
    seconds = std::max(0.3 * seconds, seconds + missing_[i].contacts * cost.contact) +
              1.5 * missing_[i].particles * cost.particle + missing_[i].builds * cost.build;
  }
  if (stopped)
    plan_.remarks.push_back(
        "the script hasn't come to its end after " + std::to_string(plan_.runs.size()) +
        " runs: a loop waits for a result, which a plan doesn't have; all figures are of the runs so far");
  tell(lammps_, plan_text(plan_));
}

}  // namespace twogrid
