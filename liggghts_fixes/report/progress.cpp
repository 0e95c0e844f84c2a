#include "liggghts_fixes/report/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

std::string duration(double seconds) {
  char text[64];
  if (seconds < 60) {
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  } else if (seconds < 3600) {
    const int s = int(std::lround(seconds));
    std::snprintf(text, sizeof text, "%d min %02d s", s / 60, s % 60);
  } else {
    const long m = std::lround(seconds / 60);
    std::snprintf(text, sizeof text, "%ld h %02ld min", m / 60, m % 60);
  }
  return text;
}

void Progress::begin(double wall, long long steps) {
  start_ = last_ = wall;
  steps_ = steps;
}

std::string Progress::line(double wall, long long done, double time) {
  if (wall - last_ < kSeconds || done <= 0 || steps_ <= 0) return "";
  last_ = wall;
  const double share = double(done) / double(steps_), spent = wall - start_;
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.1f", 100 * share);
  char clock[32];
  std::snprintf(clock, sizeof clock, "%.6g", time);
  return "twogrid: t = " + std::string(clock) + " s, " + percent + " % of this run done, " +
         duration(spent * (1 - share) / share) + " to go";
}

std::string Progress::line_within(double wall, int steps, double share, double spent, double time) {
  if (spent < kSeconds || wall - last_ < kSeconds) return "";
  last_ = wall;
  char clock[32], percent[16];
  std::snprintf(clock, sizeof clock, "%.6g", time);
  std::snprintf(percent, sizeof percent, "%.1f", 100 * share);
  return "twogrid: t = " + std::string(clock) + " s, within a coupling: " + std::to_string(steps) +
         " fluid steps are " + percent + " % of its interval, " + duration(spent * (1 - share) / share) + " to go";
}

std::string shares_text(double wall, double total, const Shares& s) {
  const auto percent = [&](double part) {
    char text[16];
    std::snprintf(text, sizeof text, "%.1f %%", total > 0 ? 100 * part / total : 0.0);
    return std::string(text);
  };
  const double known = s.deposit + s.map + s.fluid + s.output + s.force;
  return "twogrid: run of " + duration(wall) + "; shares of CPU time: DEM " + percent(std::max(0.0, total - known)) +
         ", deposit " + percent(s.deposit) + ", map and read " + percent(s.map) + ", fluid " + percent(s.fluid) +
         ", forces " + percent(s.force) + ", output " + percent(s.output);
}

}  // namespace twogrid
