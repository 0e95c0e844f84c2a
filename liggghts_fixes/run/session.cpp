#include "liggghts_fixes/run/session.h"

#include <atom.h>
#include <atom_vec.h>
#include <domain.h>
#include <input.h>
#include <lammps.h>
#include <modify.h>
#include <mpi.h>
#include <unistd.h>
#include <update.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "cfd/parallel/rank_0.h"
#include "cfd/parallel/ranks.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/insertion_state.h"
#include "liggghts_fixes/liggghts/not_restored.h"
#include "liggghts_fixes/liggghts/old_output.h"
#include "liggghts_fixes/liggghts/restart_file.h"
#include "liggghts_fixes/liggghts/tell.h"
#include "liggghts_fixes/report/status.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/script/words.h"
#include "liggghts_fixes/style_registry.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

std::vector<FixTwogrid*> fluids(LAMMPS& lammps) {
  std::vector<FixTwogrid*> found;
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* f = dynamic_cast<FixTwogrid*>(lammps.modify->fix[i])) found.push_back(f);
  return found;
}

/// LIGGGHTS initialises all fixes before it writes a restart file: as in the run in hand, whose ramps they may ask for.
class AsInRun {
 public:
  AsInRun(Update& update, const RunRequest& r) : update_(update) {
    update.whichflag = 1;
    update.beginstep = r.start.value_or(r.part_begin(update.ntimestep));
    update.endstep = std::max<bigint>(r.stop.value_or(r.part_end(update.ntimestep)), update.beginstep);
  }
  ~AsInRun() { update_.whichflag = 0, update_.beginstep = update_.endstep = 0; }
  AsInRun(const AsInRun&) = delete;
  AsInRun& operator=(const AsInRun&) = delete;

 private:
  Update& update_;
};

}  // namespace

Checkpoint checkpoint_wanted(MPI_Comm comm, const CommandLine& line) {
  Checkpoint c;
  if (line.restart.empty()) return c;
  if (line.script.empty())
    throw std::invalid_argument(
        "-restart: found no script in the command line, wanted that of the run to go on: -in FILE");
  const bool automatic = line.restart == "auto";
  if (rank_of(comm) == 0) c = automatic ? find_checkpoint_of(line.script) : find_checkpoint(line.restart);
  c.path = from_rank(comm, 0, c.path);
  c.record = from_rank(comm, 0, c.record);
  std::string passed;
  for (const std::string& s : c.passed_over) passed += "; " + s;
  passed = from_rank(comm, 0, passed);
  if (c.path.empty() && (!automatic || !passed.empty()))
    throw std::invalid_argument("-restart: found no whole checkpoint " +
                                (automatic ? "of " + line.script : "in " + line.restart) + passed +
                                "; wanted the folder of one, or none named for a new run (then without -restart)");
  return c;
}

Session::Session(LAMMPS& lammps, const CommandLine& line, Checkpoint from)
    : lammps_(lammps),
      interpreter_(lammps, line.script, line.variables),
      early_end_(lammps.world),
      from_(std::move(from)) {
  if (line.plan > 0) planner_.emplace(lammps, line.script, line.plan);
  early_end_.set_plan(
      [this] {
        long long steps = std::numeric_limits<int>::max();
        for (const FixTwogrid* f : fluids(lammps_)) steps = std::min(steps, f->steps_undecided());
        return steps;
      },
      [this] {
        long long steps = 0;
        for (const FixTwogrid* f : fluids(lammps_)) steps = std::max(steps, f->steps_to_end());
        return steps;
      });
}

int Session::run() {
  if (!from_.path.empty()) go_on();
  if (!ended_) interpreter_.run([this] { return end_here(); });
  if (planner_) {
    handle_runs({});
    if (early_end_.signal() == 0) planner_->finish(ended_, [this](const std::string& line) { interpreter_.one(line); });
  }
  return early_end_.signal() != 0 && ended_ ? early_end_.signal() : 0;
}

/// Between two commands. Before the first run there is nothing to keep; later the next run keeps it.
bool Session::end_here() {
  if (planner_ && !ended_ && (planner_->has_enough() || (early_end_.look(0) && early_end_.signal() != 0)))
    ended_ = true;
  if (!ended_ && !lammps_.update->first_update && early_end_.look(0) && early_end_.signal() != 0) {
    tell(lammps_, "twogrid: ended by signal " + std::to_string(early_end_.signal()) + " before the first run\n");
    ended_ = true;
  }
  return ended_;
}

CheckpointPlan Session::plan() const {
  for (const FixTwogrid* f : fluids(lammps_))
    if (f->checkpoint_plan().by_itself() || !f->checkpoint_plan().folder.empty()) return f->checkpoint_plan();
  return {};
}

/// A run in status.json, from its beginning to its end, however it ends.
class StatusOfRun {
 public:
  StatusOfRun(const RunRequest& r, const Update& update) : update_(update) {
    Status::of_process().begin_run(update.ntimestep, r.begin, r.end);
  }
  ~StatusOfRun() { Status::of_process().end_run(update_.ntimestep); }

 private:
  const Update& update_;
};

void Session::run_command(const Command& words) {
  planner_ ? planner_->let_runs_be_measured() : let_runs_end(lammps_, early_end_);
  for (FixTwogrid* f : fluids(lammps_)) f->before_run();
  std::optional<RunRequest> request = run_request(words, lammps_.update->ntimestep, lammps_.update->dt);
  if (!request) return stock_run(lammps_, words[0], Command(words.begin() + 1, words.end()));
  planner_ ? plan_parts(words, *request) : run_parts(words, *request);
}

/// The run's next end: of a part, or the step of a checkpoint.
long long Session::part_to(const RunRequest& r, long long step) const {
  const long long every = plan().every, to = r.part_end(step);
  return every > 0 ? std::min(to, (step / every + 1) * every) : to;
}

void Session::run_parts(const Command& words, const RunRequest& request) {
  RunRequest r = request;
  Update& update = *lammps_.update;
  const StatusOfRun status(r, update);
  bool set_up = r.pre;
  early_end_.set_interval(plan().seconds);
  if (plan().by_itself()) try_folder();
  for (bool first = true; first || update.ntimestep < r.end; first = false) {
    const long long step = update.ntimestep, to = part_to(r, step);
    if (early_end_.look(0) && early_end_.signal() != 0) {
      if (update.first_update) write_checkpoint(words, r);
      ended_ = true;
      return;
    }
    stock_run(lammps_, "run", r.words(step, to, set_up));
    interpreter_.note_run();
    set_up = r.pre;
    const long long now = update.ntimestep;
    if (end_reached(now >= r.end)) r.end = now;
    if (r.every > 0 && now == r.part_end(step)) {
      lammps_.modify->clearstep_compute();
      for (const std::string& c : r.commands) interpreter_.one(c);
      lammps_.modify->addstep_compute(now + r.every);
    }
    early_end_.look(0);
    const long long every = plan().every;
    const bool by_steps = every > 0 && now % every == 0 && now > step;
    if (!by_steps && !early_end_.checkpoint_due() && early_end_.signal() == 0) continue;
    write_checkpoint(words, r);
    set_up = true;
    if (early_end_.signal() != 0) {
      ended_ = true;
      return;
    }
  }
  for (FixTwogrid* f : fluids(lammps_)) f->tell_sureness();
}

/// As run_parts, without checkpoints and ends that come in between.
void Session::plan_parts(const Command& words, const RunRequest& r) {
  const Update& update = *lammps_.update;
  std::string line;
  for (const std::string& w : words) line += (line.empty() ? "" : " ") + w;
  planner_->begin_run(line);
  bool set_up = r.pre;
  for (bool first = true; first || update.ntimestep < r.end; first = false) {
    const long long step = update.ntimestep, to = r.part_end(step);
    planner_->begin_part(to);
    stock_run(lammps_, "run", r.words(step, to, set_up));
    planner_->end_part(to, interpreter_.commands());
    interpreter_.note_run();
    if (r.every > 0) {
      lammps_.modify->clearstep_compute();
      for (const std::string& c : r.commands) interpreter_.one(c);
      lammps_.modify->addstep_compute(to + r.every);
    }
    if (end_here()) break;
  }
  planner_->end_run();
}

/// Whether the run stands at an end that was planned within it; or at its own, shortly before that one.
bool Session::end_reached(bool at_its_own) const {
  bool reached = false;
  for (FixTwogrid* f : fluids(lammps_))
    if (f->stands_at_planned_end() || (at_its_own && f->steps_to_end() > 0)) f->end_reached(), reached = true;
  return reached;
}

CheckpointFolder Session::folder() const {
  const std::string asked = plan().folder;
  return CheckpointFolder(asked.empty() ? default_folder(interpreter_.script()) : asked);
}

/// Better now than after hours.
void Session::try_folder() const {
  if (!interpreter_.from_file())
    throw std::runtime_error(
        "checkpoint: found a script that comes from the standard input, wanted one from a file (-in FILE): "
        "a run can't be gone on with otherwise");
  on_rank_0(lammps_.world, [&] {
    folder().begin(65536);
    folder().give_up();
  });
}

void Session::write_checkpoint(const Command& words, const RunRequest& request) {
  const int signal = early_end_.signal();
  if (!interpreter_.from_file())
    return tell(
        lammps_,
        "twogrid: ended by signal " + std::to_string(signal) +
            "; a script that comes from the standard input can't be gone on with, and no checkpoint is written\n");
  const double begin = MPI_Wtime();
  const CheckpointFolder folder = this->folder();
  double bytes = 8.0 * lammps_.atom->avec->size_restart() + 65536;
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, lammps_.world);
  std::string part, path;
  on_rank_0(lammps_.world, [&] { part = folder.begin(bytes); });
  part = from_rank(lammps_.world, 0, part);
  try {
    {
      const AsInRun as_in_run(*lammps_.update, request);
      stock_write_restart(lammps_, part + "/" + kParticlesFile);
    }
    for (FixTwogrid* f : fluids(lammps_))
      if (f->has_state()) f->write_checkpoint(part + "/" + f->id + ".h5");
    const std::string insertion = InsertionState(lammps_).text(lammps_.world);
    ResumePoint p = interpreter_.here();
    p.run = words;
    p.begin = request.begin;
    p.end = request.end;
    p.step = lammps_.update->ntimestep;
    p.time = lammps_.update->get_cur_time();
    p.particles = (long long)(lammps_.atom->natoms);
    on_rank_0(lammps_.world, [&] {
      note_folder(interpreter_.script(), folder.path());
      folder.add(kInsertionFile, insertion);
      path = folder.complete(p, plan().keep, last_number(interpreter_.script()));
    });
  } catch (...) {
    if (rank_of(lammps_.world) == 0) folder.give_up();
    throw;
  }
  early_end_.checkpoint_written();
  Status::of_process().checkpoint(path, lammps_.update->ntimestep);
  if (!std::exchange(limits_said_, true))
    for (const std::string& limit : not_restored(lammps_))
      tell(lammps_, "WARNING: twogrid: checkpoint: " + limit + "\n");
  const double size = rank_of(lammps_.world) == 0 ? CheckpointFolder::size(path) : 0;
  tell(lammps_,
       "twogrid: checkpoint " + path + ", " + brief(size / 1048576) + " MB in " + brief(MPI_Wtime() - begin) + " s" +
           (signal != 0 ? ", ended by signal " + std::to_string(signal) + ": -restart goes on from it\n" : "\n"));
}

void Session::go_on() {
  for (const std::string& s : from_.passed_over) tell(lammps_, "WARNING: twogrid: " + s + "\n");
  const ResumePoint point = resume_point(from_.record);
  tell(lammps_, "twogrid: goes on from the checkpoint " + from_.path + ", step " + std::to_string(point.step) + "\n");
  Status::of_process().checkpoint(from_.path, point.step);
  interpreter_.on_run([this] {
    for (FixTwogrid* f : fluids(lammps_)) f->take_as_run();
  });
  const std::string insertion =
      from_rank(lammps_.world, 0,
                rank_of(lammps_.world) == 0 ? CheckpointFolder::content(from_.path + "/" + kInsertionFile) : "");
  set_replaying(true);
  const std::string changed = interpreter_.go_on_from(point, from_.path + "/" + kParticlesFile);
  set_replaying(false);
  take_columns_again(lammps_);
  Update& update = *lammps_.update;
  if (update.ntimestep != point.step || (long long)(lammps_.atom->natoms) != point.particles)
    throw std::runtime_error("-restart: found step " + std::to_string(update.ntimestep) + " with " +
                             std::to_string((long long)(lammps_.atom->natoms)) + " particles in " + from_.path +
                             ", wanted step " + std::to_string(point.step) + " with " +
                             std::to_string(point.particles));
  update.atime = point.time;
  update.atimestep = update.ntimestep;
  go_on_with_dumps(lammps_);
  InsertionState state(insertion, rank_of(lammps_.world), ranks_of(lammps_.world));
  for (FixTwogrid* f : fluids(lammps_)) {
    const std::string file = from_.path + "/" + f->id + ".h5";
    int there = access(file.c_str(), F_OK) == 0;
    MPI_Bcast(&there, 1, MPI_INT, 0, lammps_.world);
    if (!there) continue;
    f->go_on_from(file);
    if (!f->ranks_as_then()) state.forget_ranks();
  }
  state.restore(lammps_);
  if (point.run.empty()) return;
  Command words = point.run;
  long long end = point.end;
  if (!changed.empty()) {
    // The run may be made longer; what has been done of it stays.
    words = interpreter_.words_of(changed);
    const std::optional<RunRequest> now = words.empty() ? std::nullopt : run_request(words, point.begin, update.dt);
    if (!now || now->end < point.step)
      throw std::invalid_argument("-restart: found '" + changed + "' in the script, wanted '" + point.line +
                                  "', in which the run stands at step " + std::to_string(point.step) +
                                  ", or a run that ends later");
    end = now->end;
  }
  std::optional<RunRequest> request = run_request(words, point.begin, update.dt);
  if (!request) throw std::invalid_argument("-restart: a record of a checkpoint with a run that can't be understood");
  request->end = end;
  if (update.ntimestep >= end && point.step > point.begin) {
    const AsInRun as_in_run(update, *request);
    lammps_.init();  // fixes that a run makes take what the restart file holds for them; new ones don't
    return;
  }
  planner_ ? planner_->let_runs_be_measured() : let_runs_end(lammps_, early_end_);
  planner_ ? plan_parts(words, *request) : run_parts(words, *request);
}

}  // namespace twogrid
