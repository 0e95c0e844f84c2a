// From script and scene to what the choice of grids goes by. Pure functions.
#pragma once

#include <vector>

#include "liggghts_fixes/report/scene_numbers.h"
#include "liggghts_fixes/script/grid_choice.h"
#include "liggghts_fixes/script/script.h"

namespace twogrid {

/// The script with some cells in place of those that are still to be chosen: for what must be known before.
Script with_some_cells(const Script& script);
/// complete: of with_some_cells(), completed, with regions and variables resolved.
GridScene grid_scene(const Settings& complete, const SceneFacts& facts, const std::vector<WidthAcross>& widths);
GivenGrids given_grids(const Script& script);

}  // namespace twogrid
