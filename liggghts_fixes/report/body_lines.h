// What the scene report says of vessels and bodies in the fluid.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/report/scene_report.h"

namespace twogrid {

/// "name: value" each.
std::vector<std::string> body_lines(const Script& script, const SceneFacts& facts, const SceneNumbers& n);

}  // namespace twogrid
