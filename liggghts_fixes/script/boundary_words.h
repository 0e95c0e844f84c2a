// boundary SIDE [patch NAME shape] condition
#pragma once

#include <string>

#include "liggghts_fixes/script/script.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

/// What follows the word boundary. started: a run has taken place, so that only velocities of inlets and walls may
/// change. Throws std::invalid_argument with a sentence.
void parse_boundary(Script& script, Words& words, bool started);

/// All conditions as a script would give them after the word boundary, joined by "; ".
std::string boundary_text(const Script& script);

/// slip, noslip, inlet, pressure or periodic.
std::string condition_word(BoundaryKind kind);

}  // namespace twogrid
