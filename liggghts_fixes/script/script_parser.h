// The words of `fix ID group twogrid ...` and `fix_modify ID ...` turned into settings, by the rows of the table of
// keywords (keywords.h). Pure functions: no LIGGGHTS, no MPI. Both throw std::invalid_argument with one sentence that
// holds the keyword, what was found and what is wanted.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/script/script.h"

namespace twogrid {

/// words: what follows `fix ID group twogrid`.
Script parse_fix(const std::string& id, const std::vector<std::string>& words);

/// words: what follows `fix_modify ID`; several keywords may follow each other. started: a run has taken place, so that
/// only the velocities of inlets and walls and the times of output may still change.
void parse_fix_modify(Script& script, const std::vector<std::string>& words, bool started);

}  // namespace twogrid
