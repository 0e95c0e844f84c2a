// What the scene report says of vessels and bodies in the fluid.
#pragma once

#include <string>
#include <vector>

#include "cfd/fluid_solver.h"
#include "liggghts_fixes/report/scene_report.h"

namespace twogrid {

/// "name: value" each.
std::vector<std::string> body_lines(const Script& script, const SceneFacts& facts, const SceneNumbers& n);
/// What bodies blow into the fluid at the end of a run, a sentence each.
std::vector<std::string> blown_lines(const Script& script, const FluidSolver& fluid);

}  // namespace twogrid
