// What fix twogrid does for `auto` in fine, ratio and every: it is chosen when the first run begins, when all patches, bodies and
// particles are there, and kept by checkpoints.
#include <update.h>

#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/box.h"
#include "liggghts_fixes/liggghts/scene_facts.h"
#include "liggghts_fixes/report/body_widths.h"
#include "liggghts_fixes/report/grid_scene.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

/// What bodies ask for, and what they leave open, before the fluid has a grid.
std::vector<WidthAcross> FixTwogrid::look_at_bodies(const Settings& s, SceneFacts& facts) const {
  if (script_.bodies.empty()) return {};
  const FineGrid domain = fine_grid(s, periodic_directions(s.fluid));
  std::array<bool, 6> walls{};
  for (int side = 0; side < 6; ++side) {
    const BoundaryKind kind = s.fluid.side[side][0].kind;
    walls[side] = kind == BoundaryKind::kSlip || kind == BoundaryKind::kNoSlip;
  }
  const BodyMeasures found =
      measure_bodies(bodies_.look(domain), domain, walls, bodies_.some_particles(), facts.d_mean);
  facts.cut.emplace();
  facts.cut->open_layers = found.open_layers;
  return found.widths;
}

/// In place of `auto`, numbers of cells: those that a checkpoint was written with, else by the scene.
void FixTwogrid::choose_cells() {
  Settings& s = script_.settings;
  if (!script_.grids_auto()) return;
  names_.resolve();
  if (!script_.checkpoint_read.empty() && !beginning_) read_beginning();
  if (beginning_) {
    for (int d = 0; d < 3; ++d) {
      if (script_.fine_auto[d]) s.fine[d] = beginning_->fine[d];
      if (script_.ratio_auto[d]) s.ratio[d] = beginning_->ratio[d];
      if (s.fine[d] < 1 || s.ratio[d] < 1 || s.fine[d] % s.ratio[d] != 0)
        refuse("checkpoint read",
               script_.checkpoint_read + " with " + text(beginning_->fine[d]) + " fine cells in " + "xyz"[d] +
                   ", ratio " + text(beginning_->ratio[d]),
               "numbers of cells that the script's go with");
    }
    script_.choices = {"grids: chosen (auto) when the run began; as the checkpoint has them"};
    return;
  }
  Script some = with_some_cells(script_);
  complete(some, box_facts(*lmp));
  SceneFacts facts = scene_facts(*lmp, groupbit);
  const std::vector<WidthAcross> widths = look_at_bodies(some.settings, facts);
  const GridChoice choice = choose_grids(grid_scene(some.settings, facts, widths), given_grids(script_));
  s.fine = choice.fine, s.ratio = choice.ratio;
  script_.choices = choice.reasons, script_.end_told = choice.end_told, script_.chosen_for = facts.d_most;
}

void FixTwogrid::choose_every(const SceneFacts& facts, const FineGrid& grid) {
  if (!script_.every_auto) return;
  int& every = script_.settings.every;
  std::string why = "as the checkpoint has it";
  if (script_.checkpoint_read.empty()) {
    const AutomaticEvery chosen =
        automatic_every(scene_numbers(script_.settings, grid, facts), script_.settings, update->dt);
    every = chosen.steps, why = chosen.why;
  }
  script_.choices.push_back("every: " + std::to_string(every) + " DEM steps (auto): " + why);
}

/// Later runs: inlets may blow faster. Not in a run that is cut in parts, by checkpoints.
void FixTwogrid::lower_every(const SceneFacts& facts) {
  if (!script_.every_auto || accuracy_.on() || update->firststep != update->beginstep) return;
  Settings& s = script_.settings;
  const AutomaticEvery now = automatic_every(scene_numbers(s, fluid_->grid(), facts), s, update->dt);
  if (now.steps >= s.every) return;
  watch_.say("twogrid: every " + std::to_string(now.steps) + " (auto) in place of " + std::to_string(s.every) +
             " from this run on: " + now.why + "\n");
  s.every = now.steps;
}

}  // namespace twogrid
