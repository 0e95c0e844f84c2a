// What `-plan` says at its end. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/report/plan_model.h"

namespace twogrid {

struct PlannedFile {
  std::string name;
  double bytes = 0;
  std::string what;  ///< "21 frames, means"; may be empty
};

struct Plan {
  std::string script;
  int ranks = 1;  ///< that it was measured on
  std::vector<PlannedRun> runs;
  std::vector<PlannedFile> files;
  double empty_bytes = 0, most_bytes = 0;  ///< of a rank: before the script, and at most
  double setup_seconds = 0;                ///< commands between runs
  std::vector<std::string> remarks;        ///< sentences
};

/// Seconds of all runs, and of what lies between them.
double plan_seconds(const Plan& plan, int ranks);
/// The whole text, several lines.
std::string plan_text(const Plan& plan);
/// "0.5 s", "12 s", "3 min 20 s", "1 h 02 min", "3 days".
std::string planned_time(double seconds);

}  // namespace twogrid
