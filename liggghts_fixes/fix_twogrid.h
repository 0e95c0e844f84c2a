// fix ID group twogrid: hands LIGGGHTS' particles to the coupling and tells it when to act. No physics here.
//
//   run begins   setup          first time: deposit and read; later: what commands have changed; forces of the fluid on
//                               the particles
//   each rebuild pre_exchange   borders between ranks follow the particles (balance.h)
//   each step    pre_force      at steps that are multiples of `every` (of the absolute step number, so that run
//                               boundaries don't shift the phase): the fluid advances over the steps done since the
//                               last coupling
//                post_force     drag and pressure gradient force; this fix comes after all fixes that add forces
//                               (fix_order.h)
//                end_of_step    frames, means and the progress line, at couplings; at the last step the coupling rests
//   run ends     post_run       means written, shares of time
//
// f_ID is a per-atom array: drag 1-3 (N), pressure gradient force 4-6 (N), eps 7, fluid velocity 8-10 (m/s); it is the
// first ten columns of the particles' state, which fix property/atom "ID_state" holds ("ID_step": what each step
// needs). f_ID[1...] as a vector: compute_vector().
#pragma once

#include <fix.h>
#include <update.h>

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfd/fluid_solver.h"
#include "coupling/checkpoint/checkpoint.h"
#include "coupling/control/accuracy.h"
#include "coupling/control/schedule.h"
#include "coupling/coupling.h"
#include "coupling/output/output.h"
#include "liggghts_fixes/bodies/body_figures.h"
#include "liggghts_fixes/bodies/script_bodies.h"
#include "liggghts_fixes/liggghts/balance.h"
#include "liggghts_fixes/liggghts/motion.h"
#include "liggghts_fixes/liggghts/script_names.h"
#include "liggghts_fixes/report/planned_bed.h"
#include "liggghts_fixes/report/run_times.h"
#include "liggghts_fixes/run/planned_end.h"
#include "liggghts_fixes/run/run_watch.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/script/script_parser.h"

namespace LAMMPS_NS {
class FixPropertyAtom;
}

namespace twogrid {

class InsertionState;
struct SceneFacts;
struct WidthAcross;

/// Of an output file, for a plan.
struct PlannedOutput {
  double empty = 0, bytes = 0, means = 0;  ///< bytes of a file with its record; of a frame; of the means
  double seconds = 0;                      ///< CPU, of a frame
};

class FixTwogrid : public LAMMPS_NS::Fix {
 public:
  static constexpr const char* kStyle = "twogrid";

  // LIGGGHTS calls all of these on all ranks. Errors are thrown as exceptions with one sentence; main() ends the run.
  FixTwogrid(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixTwogrid() override;
  int setmask() override;
  void post_create() override;
  void pre_delete(bool unfix) override;
  int modify_param(int narg, char** arg) override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override;
  void pre_exchange() override;
  void setup(int) override;
  void pre_initial_integrate() override;
  void pre_force(int) override;
  void post_force(int) override;
  void end_of_step() override;
  void post_run() override;
  double compute_vector(int i) override;
  double memory_usage() override;
  using Fix::reset_timestep;
  void reset_timestep(LAMMPS_NS::bigint) override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override {}

  /// It has been set up: there is something to keep.
  bool has_state() const { return started_; }
  /// What the script has asked for.
  const CheckpointPlan& checkpoint_plan() const { return script_.checkpoints; }
  /// In a script that is said again: the commands that follow came after a run with this fix.
  void take_as_run() { has_run_ = true; }
  /// Between runs: the fluid and all that the coupling has in hand, into an HDF5 file of this path, which is neither
  /// synced nor renamed. Collective. Throws with a sentence on all ranks.
  void write_checkpoint(const std::string& path);
  /// Before the first run, when all fixes are there: it begins as the file of a checkpoint's folder says, which belongs to
  /// the particles that a restart file has brought. These get their order at once, so that commands may change them.
  /// Collective.
  void go_on_from(const std::string& path);
  /// Whether it goes on, and every rank has the part of the box that it had then.
  bool ranks_as_then() const;
  /// `output average until`: DEM steps in which no end of the run can come to be planned; steps to the planned end, 0: none.
  long long steps_undecided() const;
  long long steps_to_end() const;
  bool stands_at_planned_end() const;
  /// The run has ended there: those that follow go on to their own ends.
  void end_reached() { planned_end_.reached = true; }
  /// After a run: how sure the means are. Collective.
  void tell_sureness();
  /// For a plan (planner.h): what it does, CPU seconds and fluid steps so far; whether the ranks' borders follow the particles.
  const Settings& settings() const { return script_.settings; }
  Shares shares() const;
  long long fluid_steps() const;
  bool borders_follow() const;
  /// Velocities of inlets are those of this step of the run; 0: of the step in hand.
  void look_ahead(long long step) { names_.look_ahead(step); }
  /// What of the bed the fluid carries; a negative share: not known, nothing blows. Collective.
  PlannedBed planned_bed();
  bool nothing_moves() const { return motion_.still; }
  /// Step from which on a frame is due. None is written in a plan: those up to a step are taken for written.
  long long next_frame() { return schedule_.state().next_frame; }
  void pass_frames(long long step) { schedule_.frame_written(step, script_.settings.output.every); }
  /// What a frame and the means take. Collective.
  PlannedOutput measure_output();
  /// So many DEM steps have been passed over.
  void pass(long long steps);
  /// A run command comes, and LIGGGHTS still has what a restart file holds of the particles.
  void before_run();

 private:
  /// f(), with the fix's name and the step in front of the sentence of any exception.
  template <class F>
  auto guarded(F&& f) -> decltype(f());
  void refuse_without_set_up() const;
  void look_at_scene();
  void look_at_bodies(SceneFacts& facts) const;
  std::string memory() const;
  std::vector<WidthAcross> look_at_bodies(const Settings& settings, SceneFacts& facts) const;
  void choose_cells();
  void choose_every(const SceneFacts& facts, const FineGrid& grid);
  void lower_every(const SceneFacts& facts);
  void build();
  void open_output(const SceneFacts& facts);
  void open_planned_output(const SceneFacts& facts);
  void make_balance();
  void read_beginning();
  Layout layout(const FineGrid& grid) const;
  CheckpointParts checkpoint_parts(InsertionState* insertion);
  Moment now() const;
  Beginning beginning() const;
  void refuse_without_state() const;
  void sync_output();
  void keep_checkpoint();
  void read_checkpoint();
  Particles particles();
  void couple();
  void end_coupling();
  bool takes_means() const;
  void meet_conditions();
  void note_conditions();
  NumberList conditions_kept();
  void adjust_steps();
  bool ends_by_itself() const;
  bool frame_due() const;
  void write_frame(const Particles& p);

  Script script_;
  ScriptNames names_;
  ScriptBodies bodies_;
  BodyFigures body_figures_;
  std::string id_in_restart_;  // of a fix twogrid whose state the restart file held when this fix was made
  double chosen_skin_ = 0;     // of -skin best (m); 0: the script's stays
  // Owned by LIGGGHTS: kParticleColumns and kStepColumns values a particle.
  LAMMPS_NS::FixPropertyAtom *state_ = nullptr, *step_ = nullptr;
  std::unique_ptr<FluidSolver> fluid_;
  std::unique_ptr<Coupling> coupling_;
  std::unique_ptr<Output> output_;  // null: none wanted
  Accuracy accuracy_;
  std::optional<Beginning> beginning_;  // of a checkpoint, until the first run is set up
  bool in_folder_ = false;              // one of -restart, which hands over insertion and the particles' columns itself
  bool kept_ = false;                   // a command has written or read a checkpoint
  std::unique_ptr<Balance> balance_;    // null: not wanted
  bool balance_said_ = false;

  /// Of the flow, when the last run ended; for the means.
  struct {
    bool known = false;
    int average_said = 0;  // so often had the script said it by then; for a checkpoint's run it says it again
    std::vector<double> value;
  } conditions_;

  Schedule schedule_;
  PlannedEnd planned_end_;
  bool set_up_ = false;   // LIGGGHTS has set up a run since this fix was made or modified
  bool has_run_ = false;  // so has another process with this script
  bool started_ = false;  // the coupling has deposited once
  bool gravity_varies_ = false;
  Motion motion_;         // of this run
  bool watchers_ = true;  // see any_watchers()
  bool quiet_ = false;    // this step changes nothing

  double passed_time_ = 0;                     // of a plan (s)
  double output_seconds_ = 0;                  // CPU, of runs before the one in hand
  double empty_file_ = 0, means_in_file_ = 0;  // bytes, of a plan

  BoxFacts box_;  // for which the fluid was made
  RunWatch watch_;
  RunTimes times_;
};

template <class F>
auto FixTwogrid::guarded(F&& f) -> decltype(f()) {
  try {
    return f();
  } catch (const EndedBySignal&) {
    throw;
  } catch (const std::exception& e) {
    const std::string when = started_ ? " (step " + std::to_string(update->ntimestep) + ")" : "";
    throw std::runtime_error("fix " + std::string(id) + " twogrid: " + e.what() + when);
  }
}

}  // namespace twogrid
