// What a user sees while a run goes on, and the shares of time after it.
#pragma once

#include <string>

#include "coupling/coupling.h"

namespace twogrid {

/// "1 h 02 min", "3 min 20 s", "12.3 s".
std::string duration(double seconds);

/// Decides when a progress line is due, and writes it.
class Progress {
 public:
  /// A run of `steps` DEM steps begins; wall: seconds of a clock.
  void begin(double wall, long long steps);
  /// A line when at least kSeconds have passed since the last one, else "". done: steps of this run so far; time: s.
  std::string line(double wall, long long done, double time);
  /// The same within a coupling that takes longer than that: after `steps` fluid steps, which are `share` of the interval and have
  /// taken `spent` seconds.
  std::string line_within(double wall, int steps, double share, double spent, double time);

  static constexpr double kSeconds = 10;

 private:
  double start_ = 0, last_ = 0;
  long long steps_ = 0;
};

/// One line: where the CPU time of a run went. total: CPU seconds of all parts, particles included; all figures summed
/// over the ranks.
std::string shares_text(double wall, double total, const Shares& shares);

}  // namespace twogrid
