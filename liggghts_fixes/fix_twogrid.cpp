#include "liggghts_fixes/fix_twogrid.h"

#include <atom.h>
#include <comm.h>
#include <fix_property_atom.h>
#include <force.h>
#include <integrate.h>
#include <lammps.h>
#include <modify.h>
#include <neighbor.h>
#include <output.h>
#include <pair.h>
#include <update.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "cfd/boundary/region_outline.h"
#include "cfd/parallel/rank_0.h"
#include "liggghts_fixes/contacts/pair_switch.h"
#include "liggghts_fixes/liggghts/box.h"
#include "liggghts_fixes/liggghts/particle_columns.h"
#include "liggghts_fixes/liggghts/positions.h"
#include "liggghts_fixes/liggghts/restart_file.h"
#include "liggghts_fixes/liggghts/run_record.h"
#include "liggghts_fixes/liggghts/scene_facts.h"
#include "liggghts_fixes/liggghts/unsupported.h"
#include "liggghts_fixes/liggghts/watchers.h"
#include "liggghts_fixes/report/body_lines.h"
#include "liggghts_fixes/report/grid_scene.h"
#include "liggghts_fixes/report/memory_need.h"
#include "liggghts_fixes/report/open_areas.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/run/still_files.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/output_words.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

FixTwogrid::FixTwogrid(LAMMPS* lammps, int narg, char** arg)
    : Fix(lammps, narg, arg),
      names_(*lammps, script_, id),
      bodies_(*lammps, script_, names_, groupbit),
      watch_(*lammps, id) {
  guarded([&] {
    script_ = parse_fix(id, std::vector<std::string>(arg + 3, arg + narg));
    refuse_unsupported(*lmp, id, kStyle);
    if (!script_.grids_auto()) memory();
    Script early = with_some_cells(script_);  // what the box alone already rules out
    complete(early, box_facts(*lmp));
  });
  vector_flag = 1;
  size_vector = Report::kValues;
  global_freq = 1;
  extvector = 0;
  peratom_flag = 1;
  size_peratom_cols = kUserColumns;
  peratom_freq = 1;
  nevery = 1;
  atom->add_callback(0);
}

FixTwogrid::~FixTwogrid() {
  atom->delete_callback(id, 0);
}

int FixTwogrid::setmask() {
  return FixConst::PRE_INITIAL_INTEGRATE | FixConst::PRE_EXCHANGE | FixConst::PRE_NEIGHBOR | FixConst::PRE_FORCE |
         FixConst::POST_FORCE | FixConst::END_OF_STEP;
}

void FixTwogrid::post_create() {
  if (state_) return;
  id_in_restart_ = id_in_restart(*lmp);
  const std::string name = id;
  guarded([&] {
    check_columns_in_restart(*lmp, name + "_state", kParticleColumns);
    check_columns_in_restart(*lmp, name + "_step", kStepColumns);
  });
  state_ = keep_with_particles(*lmp, name + "_state", kParticleColumns);
  step_ = keep_with_particles(*lmp, name + "_step", kStepColumns);
  // This fix's grow_arrays has to be called after the state's, so that it finds the new array.
  int* const grow = atom->extra_grow;
  int* const own = std::find(grow, grow + atom->nextra_grow, modify->find_fix(id));
  std::rotate(own, own + 1, grow + atom->nextra_grow);
  array_atom = state_->array_atom;
}

void FixTwogrid::pre_delete(bool unfix) {
  if (unfix && state_) {
    modify->delete_fix((std::string(id) + "_step").c_str(), true);
    modify->delete_fix((std::string(id) + "_state").c_str(), true);
    state_ = step_ = nullptr;
  }
}

void FixTwogrid::reset_timestep(bigint) {
  if (!coupling_) return;  // no run yet: nothing hangs on the number of the step
  guarded([&] {
    const std::string name = id;
    refuse("reset_timestep", "it after a run with this fix, whose couplings and frames go by the number of the step",
           "it before the fix's first run, or 'unfix " + name +
               "', reset_timestep, and the fix again (the fluid then begins anew); "
               "the fluid's own time is f_" +
               name + "[1]");
  });
}

void FixTwogrid::grow_arrays(int) {
  array_atom = state_ ? state_->array_atom : nullptr;
}

int FixTwogrid::modify_param(int narg, char** arg) {
  guarded([&] {
    set_up_ = false;
    const OutputSettings before = script_.settings.output;
    parse_fix_modify(script_, std::vector<std::string>(arg, arg + narg), fluid_ || has_run_);
    const std::string dropped = fluid_ || has_run_ ? "" : dropped_output(before, script_.settings.output);
    if (!dropped.empty()) watch_.warn(dropped);
    size_vector = Report::kValues + BodyFigures::count(script_.bodies.size());
    if (!script_.settings.output.file.empty()) check(script_.settings.output);
    kept_ = kept_ || !script_.checkpoint_write.empty() || !script_.checkpoint_read.empty();
    if (!script_.checkpoint_write.empty()) keep_checkpoint();
    if (files_are_still() && !script_.checkpoint_read.empty())
      script_.checkpoint_read = from_rank(world, 0, still_path_to_read(script_.checkpoint_read));
  });
  return narg;
}

void FixTwogrid::look_at_bodies(SceneFacts& facts) const {
  const FluidSettings& s = script_.settings.fluid;
  facts.end_told = script_.end_told, facts.chosen_for = script_.chosen_for;
  if (s.bodies.empty()) return;
  bodies_.find_known(facts.walls, s, fluid_->grid());
  facts.open_area = open_areas(world, s, *fluid_);
  facts.drawn_blowing = bodies_.drawn_areas(s, fluid_->grid());
  if (coupling_->open_nodes()) facts.nodes = coupling_->open_nodes()->figures();
  if (fluid_->cut()) facts.cut = *fluid_->cut();
}

/// Later runs: what has come to be worth a warning since the scene report.
void FixTwogrid::look_at_scene() {
  std::vector<std::string> now = motion_.warnings;
  if (started_) {
    SceneFacts facts = scene_facts(*lmp, groupbit);
    Settings& s = script_.settings;
    facts.ahead = names_.ahead();
    look_at_bodies(facts);
    lower_every(facts);
    for (const std::string& w : scene_warnings(s, fluid_->grid(), facts, scene_numbers(s, fluid_->grid(), facts)))
      now.push_back(w);
  }
  watch_.warn_of_news(now);
}

void FixTwogrid::init() {
  guarded([&] {
    refuse_unsupported(*lmp, id, kStyle);
    if (fluid_) check_box(*lmp, box_, id);
    if (fluid_) bodies_.resolve(script_.settings.fluid, fluid_->grid());
    motion_ = find_motion(*lmp, *this);
    watchers_ = any_watchers(*lmp);
    if (!(update->dt > 0)) refuse("timestep", text(update->dt), "a DEM step above 0 (s)");
    if (chosen_skin_ > 0) neighbor->skin = chosen_skin_;  // whatever the script has said since
    if (!fluid_) build();
    coupling_->set_gravity(find_weights(*lmp, false));
    gravity_varies_ = weights_vary(*lmp);
    names_.resolve();
    names_.renew(fluid_->settings());
    names_.check_region_faces(fluid_->grid());
    fluid_->settings().check_flow(fluid_->grid());  // inlets may have changed since the last run
    look_at_scene();
  });
}

/// Throws where it is not there.
std::string FixTwogrid::memory() const {
  return check_memory(world, script_.settings, Int3{comm->procgrid[0], comm->procgrid[1], comm->procgrid[2]},
                      most_cells(), script_.bodies.size());
}

void FixTwogrid::build() {
  Settings& s = script_.settings;
  choose_cells();
  watch_.say(memory());
  complete(script_, box_facts(*lmp));
  names_.resolve();
  measure_regions(s.fluid, s.domain);
  const FineGrid grid = fine_grid(s, periodic_directions(s.fluid));
  s.fluid.check_flow(grid);
  bodies_.resolve(s.fluid, grid);
  SceneFacts facts = scene_facts(*lmp, groupbit);
  facts.still = motion_.still, facts.ahead = names_.ahead();
  if (facts.d_max == 0) atom->sortfreq = 0;  // without particles LIGGGHTS ends, for want of a width of its bins
  if (!script_.checkpoint_read.empty()) {
    if (!beginning_) read_beginning();
    check_scene(script_.checkpoint_read, *beginning_, s, grid);
  } else if (best_skin_option()) {
    chosen_skin_ = choose_skin(*lmp, facts);
  }
  choose_every(facts, grid);
  if (s.accuracy > 0 && !s.tolerance_given) s.fluid.pressure_rtol = Accuracy::tolerance(s.accuracy);
  schedule_ = Schedule(s.accuracy > 0 && script_.every_auto);
  accuracy_ = Accuracy(s.accuracy, s.every, script_.every_auto, s.fluid.cfl, !s.cfl_given && s.fluid.dt == 0);

  const Layout layout = this->layout(grid);
  for (int d = 0; d < 3; ++d) facts.fluid_bricks[d] = int(layout.cuts()[d].size()) - 1;
  fluid_ = std::make_unique<FluidSolver>(world, grid, layout, s.fluid);
  fluid_->watch_steps([this](int steps, double share) { watch_.look_within(steps, share, fluid_->time()); });
  const ParticleRegion region = particle_region(*lmp);
  coupling_ = std::make_unique<Coupling>(world, s, *fluid_, region.lo, region.hi, region.reach);
  body_figures_.take(fluid_->body_forces(), coupling_->report());
  install_models({script_, *fluid_, *coupling_, [this](const std::string& n) { return particle_property(*lmp, n); }});
  watch_.look_at(CouplingWatch(s));
  make_balance();
  open_output(facts);
  look_at_bodies(facts);
  watch_.say(scene_report(script_, grid, facts));
  for (const std::string& sentence : doubts(*lmp)) watch_.warn(sentence);
  for (const std::string& sentence : bodies_.doubts()) watch_.warn(sentence);
  if (!state_->recent_restart && !id_in_restart_.empty())
    watch_.warn(
        "the restart file holds what a fix twogrid of ID " + id_in_restart_ +
        " knew of the particles, which this fix can't take over: give it that ID, or it begins anew; the fluid starts "
        "from 'initial u' at time 0 in any case");
  watch_.have_said(scene_warnings(s, grid, facts, scene_numbers(s, grid, facts)));
  box_ = box_facts(*lmp);
  check_restarted(state_->recent_restart, script_.checkpoint_read);
  if (state_->recent_restart && script_.checkpoint_read.empty())
    watch_.warn(
        "the particles come from a restart file, which holds no fluid: the fluid starts from 'initial u' at time 0");
}

Particles FixTwogrid::particles() {
  array_atom = state_->array_atom;
  Particles p = view_particles(*lmp, groupbit, motion_, *state_, *step_);
  p.watched = watchers_ || motion_.still || update->ntimestep == output->next ||
              update->ntimestep == update->laststep || frame_due();
  return p;
}

void FixTwogrid::pre_exchange() {
  guarded([&] { check_positions(*lmp); });
  if (!balance_ || !balance_->move_borders()) return;
  guarded([&] {
    const ParticleRegion region = particle_region(*lmp);
    coupling_->move_region(region.lo, region.hi, region.reach);
  });
  if (!balance_said_)
    watch_.say("twogrid: the ranks' parts of the box follow the particles: the fullest had " +
               text(balance_->fullest()) + " times the mean (-balance off keeps them)\n");
  balance_said_ = true;
}

void FixTwogrid::setup(int) {
  guarded([&] {
    Particles p = particles();
    const bool fresh = !started_ && script_.checkpoint_read.empty();
    if (!script_.checkpoint_read.empty()) read_checkpoint();
    // Not before: LIGGGHTS sets the state of a new fix to its defaults at the beginning of set-up.
    coupling_->start(p, update->dt);
    if (fresh) body_figures_.take(fluid_->body_forces(), coupling_->report());
    started_ = set_up_ = true;
    names_.run_is_set_up();
    meet_conditions();
    if (gravity_varies_) coupling_->set_gravity(find_weights(*lmp, true));
    coupling_->force(p, update->dt, false);
    watch_.look(coupling_->report(), schedule_.steps());
    watch_.warn_of_unused_options("-fluid_", "-fluid_momentum_");  // asked for when viscosity is first implicit

    if (output_)
      for (const std::string& sentence : output_->begin(update->ntimestep, update->ntimestep - frame_due()))
        watch_.say("twogrid: " + sentence + "\n");
    if (frame_due()) write_frame(p);
    schedule_.begin_run();
    watch_.begin_run(update->laststep - update->firststep, schedule_);
    output_seconds_ += times_.output_seconds();
    times_.begin(update->ntimestep, coupling_->shares());
  });
}

void FixTwogrid::refuse_without_set_up() const {
  if (!set_up_)
    refuse("run", "'pre no' after fix or fix_modify twogrid",
           "a run with set-up, which is LIGGGHTS' default: leave 'pre no' out");
}

/// run ... pre no begins without set-up.
void FixTwogrid::pre_initial_integrate() {
  guarded([&] {
    refuse_without_set_up();
    if (!coupling_->resting()) return;
    Particles p = particles();
    coupling_->start(p, update->dt);
    meet_conditions();
  });
}

void FixTwogrid::pre_force(int) {
  guarded([&] {
    schedule_.count_step(update->ntimestep, update->dt, script_.settings.every);
    if (schedule_.coupling()) couple();
    // Nothing moves: between couplings and outputs every step is the one before, contacts included.
    quiet_ = motion_.still && !schedule_.coupling() && update->ntimestep != output->next &&
             modify->n_end_of_step == 1 && update->ntimestep != update->laststep;
    if (motion_.still) skip_pair(*update->integrate, quiet_, force->pair && force->pair->compute_flag);
  });
}

void FixTwogrid::couple() {
  watch_.look(schedule_, script_.most_lost);
  Particles p = particles();
  const bool check = accuracy_.due();
  watch_.begin_coupling();
  coupling_->advance(p, schedule_.steps(), schedule_.mean_dt(), check);
  body_figures_.take(fluid_->body_forces(), coupling_->report());
  accuracy_.count_coupling();
  if (check) adjust_steps();
  watch_.look(coupling_->report(), schedule_.steps());
  // The coupling has changed velocities. Ghosts must follow, or else the two sides of a contact across a border of
  // ranks or of the box see different damping, and momentum is lost.
  comm->forward_comm();
  schedule_.end_interval();
}

/// Steps for the accuracy wanted, after a coupling that was checked.
void FixTwogrid::adjust_steps() {
  const Report& r = coupling_->report();
  accuracy_.adjust(r.step_error, r.coupling_error, r.max_drag_number);
  script_.settings.every = accuracy_.every();
  fluid_->limit_courant_number(accuracy_.cfl());
  // Inlets that follow a variable are evaluated at the next coupling: LIGGGHTS must be told the step, which may be new.
  if (started_) modify->addstep_compute(update->ntimestep + script_.settings.every);
}

void FixTwogrid::post_force(int) {
  if (quiet_) {
    coupling_->repeat_force();
    return;
  }
  guarded([&] {
    Particles p = particles();
    if (gravity_varies_) coupling_->set_gravity(find_weights(*lmp, true));
    coupling_->force(p, update->dt, true);
  });
}

void FixTwogrid::end_of_step() {
  if (quiet_) return;
  Particles moved = particles();
  coupling_->finish_step(moved);
  if (schedule_.coupling()) end_coupling();
  // Before other fixes' post_run, which may change particles.
  if (update->ntimestep == update->laststep) guarded([&] { coupling_->rest(moved); });
}

void FixTwogrid::post_run() {
  if (!set_up_) return;
  guarded([&] {
    if (output_) output_->finish();
    note_conditions();
    const std::string times = times_.text(world, coupling_->shares());
    if (!files_are_still() && times_.done(update->ntimestep) > 0) watch_.say(times + "\n");
    watch_.warn_of_unused_options("-", "");
    if (accuracy_.on()) watch_.say(accuracy_text(accuracy_, script_) + "\n");
    for (const std::string& sentence : blown_lines(script_, *fluid_)) watch_.say("twogrid: " + sentence + "\n");
    Particles p = particles();
    coupling_->rest(p);
  });
}

double FixTwogrid::compute_vector(int i) {
  if (!coupling_) return 0;
  if (i == 0) return coupling_->report().fluid_time + passed_time_;
  if (i < Report::kValues) return coupling_->report().values(script_.settings.every)[i];
  const std::size_t at = i - Report::kValues;
  return at < body_figures_.value.size() ? body_figures_.value[at] : 0;
}

double FixTwogrid::memory_usage() {
  return fluid_ ? 100.0 * sizeof(double) * double(fluid_->layout().cells(comm->me).count()) : 0;
}

}  // namespace twogrid
