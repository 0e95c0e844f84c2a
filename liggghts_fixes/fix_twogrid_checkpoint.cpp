// What fix twogrid does for checkpoints (coupling/checkpoint/checkpoint.h).
#include <neighbor.h>
#include <update.h>

#include <utility>

#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/particle_columns.h"
#include "liggghts_fixes/liggghts/rank_parts.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

void FixTwogrid::refuse_without_state() const {
  if (!started_ || !coupling_->resting())
    refuse("checkpoint write", "it before the first run with this fix", "it after a run: there is nothing to keep yet");
}

CheckpointParts FixTwogrid::checkpoint_parts() {
  std::vector<NumberList> numbers{numbers_of("watch", watch_.coupling())};
  if (accuracy_.on()) numbers.push_back(numbers_of("accuracy", accuracy_));
  if (random_) numbers.push_back(numbers_of("random", *random_)), numbers.back().of_script = true;
  if (balance_) numbers.push_back(numbers_of("balance", *balance_));
  return {world, script_.settings, *fluid_, *coupling_, schedule_.state(), output_.get(), std::move(numbers)};
}

Moment FixTwogrid::now() const {
  return {update->ntimestep, particles_of_all_ranks(*lmp)};
}

Beginning FixTwogrid::beginning() const {
  return {script_.settings.every, chosen_skin_, rank_parts(*lmp)};
}

void FixTwogrid::write_checkpoint(const std::string& path) {
  guarded([&] {
    refuse_without_state();
    random_ = std::make_unique<RandomState>(*lmp);
    write_plain_checkpoint(path, checkpoint_parts(), now(), beginning());
    random_.reset();
  });
}

void FixTwogrid::go_on_from(const std::string& path) {
  guarded([&] {
    if (fluid_) refuse("checkpoint read", "it after the first run with this fix", "it before");
    script_.checkpoint_read = path;
  });
}

/// What a checkpoint says before the fluid is made.
void FixTwogrid::read_beginning(const FineGrid& grid) {
  const Beginning then = twogrid::read_beginning(world, script_.checkpoint_read, script_.settings, grid, now());
  if (script_.every_auto) script_.settings.every = then.every;
  if (then.skin > 0) neighbor->skin = chosen_skin_ = then.skin;
  const bool cuts = then.ranks.known() && (balance_option() || then.ranks.equal);
  if (!cuts || !restore_borders(*lmp, then.ranks)) return;
  restored_ = then.ranks;
  random_ = std::make_unique<RandomState>(*lmp);
}

/// fix_modify checkpoint write.
void FixTwogrid::keep_checkpoint() {
  const std::string path = std::exchange(script_.checkpoint_write, "");
  if (replaying()) return;
  refuse_without_state();
  random_ = std::make_unique<RandomState>(*lmp);
  twogrid::write_checkpoint(path, checkpoint_parts(), now(), beginning());
  random_.reset();
  watch_.say("twogrid: the fluid of step " + std::to_string(update->ntimestep) + " is in " + path + "\n");
}

void FixTwogrid::read_checkpoint() {
  const std::string path = std::exchange(script_.checkpoint_read, "");
  twogrid::read_checkpoint(path, checkpoint_parts());
  if (accuracy_.on()) fluid_->limit_courant_number(accuracy_.cfl());
  watch_.say("twogrid: the fluid goes on from " + path + ", t = " + text(fluid_->time()) + " s\n");
}

void FixTwogrid::setup_pre_exchange() {
  if (!update->setupflag) return;  // write_restart, write_data: nothing begins
  guarded([&] {
    if (restored_.known()) restore_order(*lmp, std::exchange(restored_, {}));
  });
  pre_exchange();
}

}  // namespace twogrid
