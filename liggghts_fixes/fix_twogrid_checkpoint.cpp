// What fix twogrid does for checkpoints (coupling/checkpoint/checkpoint.h).
#include <comm.h>
#include <neighbor.h>
#include <update.h>

#include <utility>

#include "cfd/parallel/rank_0.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/box.h"
#include "liggghts_fixes/liggghts/insertion_state.h"
#include "liggghts_fixes/liggghts/mesh_order.h"
#include "liggghts_fixes/liggghts/particle_columns.h"
#include "liggghts_fixes/liggghts/rank_parts.h"
#include "liggghts_fixes/liggghts/restart_file.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/run/still_files.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

void FixTwogrid::refuse_without_state() const {
  if (!started_ || !coupling_->resting())
    refuse("checkpoint write", "it before the first run with this fix", "it after a run: there is nothing to keep yet");
}

/// insertion: null: the folder's own file holds it.
CheckpointParts FixTwogrid::checkpoint_parts(InsertionState* insertion) {
  std::vector<NumberList> numbers{numbers_of("watch", watch_.coupling())};
  if (insertion) {
    numbers.push_back(numbers_of("insertion", *insertion));
    numbers.back().of_script = true;
  }
  if (!script_.bodies.empty()) numbers.push_back(numbers_of("bodies", body_figures_));
  if (script_.settings.output.until > 0) {
    numbers.push_back(numbers_of("planned_end", planned_end_));
    numbers.back().of_script = true;
  }
  if (takes_means()) numbers.push_back(conditions_kept());
  if (accuracy_.on()) numbers.push_back(numbers_of("accuracy", accuracy_));
  if (balance_ && !beginning_) numbers.push_back(numbers_of("balance", *balance_));
  return {world, script_.settings, *fluid_, *coupling_, schedule_.state(), output_.get(), std::move(numbers)};
}

Moment FixTwogrid::now() const {
  return {update->ntimestep, particles_of_all_ranks(*lmp)};
}

Beginning FixTwogrid::beginning() const {
  return {"", script_.settings.every, {0, 0, 0}, {0, 0, 0}, chosen_skin_, rank_parts(*lmp)};
}

void FixTwogrid::write_checkpoint(const std::string& path) {
  guarded([&] {
    refuse_without_state();
    sync_output();
    write_plain_checkpoint(path, checkpoint_parts(nullptr), now(), beginning());
  });
}

/// A checkpoint goes on in the output file: its frames must be there.
void FixTwogrid::sync_output() {
  const std::string failure = output_ ? output_->sync() : "";
  if (!failure.empty()) watch_.warn(failure);
}

void FixTwogrid::go_on_from(const std::string& path) {
  guarded([&] {
    if (fluid_) refuse("checkpoint read", "it after the first run with this fix", "it before");
    script_.checkpoint_read = path;
    in_folder_ = true;
    read_beginning();
    if (beginning_->ranks.ordered) restore_order(*lmp, beginning_->ranks);
    beginning_->ranks.ordered = false;
  });
}

void FixTwogrid::before_run() {
  if (!fluid_ && !in_folder_ && !script_.checkpoint_read.empty()) take_columns_again(*lmp, "release_fix_insert_stream");
}

bool FixTwogrid::ranks_as_then() const {
  return beginning_ && beginning_->ranks.known();
}

/// Before a run's set-up, which may move borders: with what was known of them.
void FixTwogrid::make_balance() {
  if (!balance_option()) return;
  balance_ = std::make_unique<Balance>(*lmp);
  if (beginning_ && beginning_->ranks.known())
    read_numbers(world, script_.checkpoint_read, fluid_->layout(), numbers_of("balance", *balance_));
}

/// What a checkpoint says before the fluid is made.
void FixTwogrid::read_beginning() {
  beginning_ = twogrid::read_beginning(world, script_.checkpoint_read, now());
  if (script_.every_auto && beginning_->every > 0) script_.settings.every = beginning_->every;
  if (beginning_->skin > 0) neighbor->skin = chosen_skin_ = beginning_->skin;
  RankParts& ranks = beginning_->ranks;
  const bool as_then = ranks.known() && (balance_option() || ranks.equal) && restore_borders(*lmp, ranks);
  if (!as_then) ranks = RankParts{};
}

Layout FixTwogrid::layout(const FineGrid& grid) const {
  const bool as_then = beginning_ && !beginning_->ranks.cuts[0].empty() && !fluid_bricks_option(comm->nprocs);
  return as_then ? Layout(grid, beginning_->ranks.cuts, beginning_->ranks.fluid_brick)
                 : fluid_layout(*lmp, grid, script_.settings.ratio);
}

/// fix_modify checkpoint write.
void FixTwogrid::keep_checkpoint() {
  const std::string path = std::exchange(script_.checkpoint_write, "");
  const auto agreed = [&](const std::string& of_rank_0) { return from_rank(world, 0, of_rank_0); };
  if (replaying()) return;
  refuse_without_state();
  sync_output();
  InsertionState insertion(*lmp);
  twogrid::write_checkpoint(agreed(still_path(path)), checkpoint_parts(&insertion), now(), beginning());
  watch_.say("twogrid: the fluid of step " + std::to_string(update->ntimestep) + " is in " + path + "\n");
}

void FixTwogrid::read_checkpoint() {
  const std::string path = std::exchange(script_.checkpoint_read, "");
  InsertionState insertion(*lmp, true);
  twogrid::read_checkpoint(path, checkpoint_parts(in_folder_ ? nullptr : &insertion));
  if (!ranks_as_then()) insertion.forget_ranks();
  if (!in_folder_) insertion.restore(*lmp);
  beginning_.reset();
  if (accuracy_.on()) fluid_->limit_courant_number(accuracy_.cfl());
  watch_.say("twogrid: the fluid goes on from " + path + ", t = " + text(fluid_->time()) + " s\n");
}

void FixTwogrid::setup_pre_exchange() {
  if (!update->setupflag) return;  // write_restart, write_data: nothing begins
  guarded([&] {
    if (beginning_ && beginning_->ranks.ordered) restore_order(*lmp, beginning_->ranks);
  });
  pre_exchange();
}

/// Where checkpoints are, a run's beginning must not hang on the runs before.
void FixTwogrid::setup_pre_neighbor() {
  if (!update->setupflag) return;
  if (script_.checkpoints.by_itself() || kept_ || restarting()) order_meshes(*lmp);
  if (beginning_) find_mesh_velocities(*lmp);
}

}  // namespace twogrid
