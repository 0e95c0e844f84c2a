// What a user should know about a scene before it runs: its numbers, and warnings with their remedy. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "coupling/control/accuracy.h"
#include "liggghts_fixes/report/scene_numbers.h"
#include "liggghts_fixes/script/script.h"

namespace twogrid {

/// What this scene doesn't need and doesn't pay for, one line each.
std::vector<std::string> scene_savings(const Settings& settings, const SceneFacts& facts);

/// One sentence each, with what to change.
std::vector<std::string> scene_warnings(const Settings& settings, const FineGrid& grid, const SceneFacts& facts,
                                        const SceneNumbers& numbers, bool every_auto = false);

/// The whole report, several lines.
std::string scene_report(const Script& script, const FineGrid& grid, const SceneFacts& facts);

/// What the checks of a run found, and a warning where it is more than was wanted.
std::string accuracy_text(const Accuracy& accuracy, const Script& script);

}  // namespace twogrid
