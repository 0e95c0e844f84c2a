// What fix twogrid does for a plan (liggghts_fixes/run/planner.h).
#include <comm.h>
#include <update.h>

#include <stdexcept>

#include "cfd/parallel/rank_0.h"
#include "coupling/control/stopwatch.h"
#include "coupling/output/averages.h"
#include "coupling/output/run_files.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/run_record.h"
#include "liggghts_fixes/liggghts/scene_facts.h"
#include "liggghts_fixes/report/planned_bed.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/run/still_files.h"
#include "liggghts_fixes/script/keywords.h"

namespace twogrid {

using namespace LAMMPS_NS;

Shares FixTwogrid::shares() const {
  Shares s;
  if (coupling_) s = coupling_->shares();
  s.output = output_seconds_ + times_.output_seconds();
  return s;
}

long long FixTwogrid::fluid_steps() const {
  return coupling_ ? coupling_->report().fluid_steps : 0;
}

/// In a file of the moment. Means are taken from the beginning, so that their cost is seen.
void FixTwogrid::open_planned_output(const SceneFacts&) {
  Settings s = script_.settings;
  OutputSettings& out = s.output;
  on_rank_0(world, [&] {
    if (!can_be_written(out.file))
      throw std::runtime_error("the file '" + out.file +
                               "' cannot be written (no such folder, or none to write to); give the path of a file in "
                               "a directory that exists and may be written (fix_modify ID output file)");
    if (!restarting()) try {
        begin_files(out);
      } catch (const std::exception& e) {
        watch_.warn(std::string("the run would end at its beginning: ") + e.what());
      }
  });
  Record record = run_record(*lmp);
  record.settings = settings_texts(script_);
  out.file = from_rank(world, 0, comm->me == 0 ? still_path(out.file) : "");
  out.overwrite = true;
  out.keep_old = false;
  out.until = 0;
  if (out.average_from > 0) out.average_from = 0;
  if (script_.checkpoint_read.empty()) out.average_auto = false;
  output_ = std::make_unique<Output>(world, s, *fluid_, record);
}

PlannedOutput FixTwogrid::measure_output() {
  PlannedOutput cost;
  if (!output_ || !started_) return cost;
  guarded([&] {
    const std::string file = script_.settings.output.file;
    const auto size = [&] { return from_rank(world, 0, comm->me == 0 ? std::to_string(still_bytes(file)) : ""); };
    const double empty = std::stod(size());
    Particles p = particles();
    output_->finish();
    const double with_means = std::stod(size());
    const double begin = cpu_seconds();
    output_->frame(coupling_->report().fluid_time, long(update->ntimestep), p);
    cost.seconds = cpu_seconds() - begin;
    cost.bytes = std::stod(size()) - with_means;
    if (empty_file_ == 0) empty_file_ = empty, means_in_file_ = with_means - empty;
    cost.empty = empty_file_, cost.means = means_in_file_;
  });
  return cost;
}

PlannedBed FixTwogrid::planned_bed() {
  if (!fluid_) return {};
  Settings now = script_.settings;
  now.fluid = fluid_->settings();
  const FineGrid& grid = fluid_->grid();
  SceneFacts facts = scene_facts(*lmp, groupbit);
  look_at_bodies(facts);
  const SceneNumbers n = scene_numbers(now, grid, facts);
  return {carried_share(now, grid, n, settled_bed(now, grid, facts)), n.U_bed};
}

bool FixTwogrid::borders_follow() const {
  return balance_ && balance_->can_be_moved();
}

void FixTwogrid::pass(long long steps) {
  if (!coupling_) return;
  passed_time_ += double(steps) * update->dt;
  // The coupling then begins anew, as at a multiple of `every`.
  schedule_.state().steps = int(update->ntimestep % script_.settings.every);
  schedule_.state().time = schedule_.state().steps * update->dt;
}

}  // namespace twogrid
