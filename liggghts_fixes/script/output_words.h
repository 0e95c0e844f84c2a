// output ...
#pragma once

#include <string>

#include "coupling/settings.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

/// What follows the word output. started: a run has taken place, after which only the times of frames and means may change.
/// Throws std::invalid_argument with a sentence.
void parse_output(OutputSettings& output, Words& words, bool started);
/// As a script would give it; empty: no frames.
std::string output_text(const OutputSettings& output);
/// What a line before the first run has dropped of what an earlier one said, as a sentence; empty: nothing.
std::string dropped_output(const OutputSettings& before, const OutputSettings& now);

}  // namespace twogrid
