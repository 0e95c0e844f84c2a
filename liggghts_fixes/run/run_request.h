// What `run` and `run_time` ask for. Plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace twogrid {

struct RunRequest {
  long long begin = 0, end = 0;          ///< first and last step
  std::optional<long long> start, stop;  ///< of ramps, as given
  bool pre = true, post = true;
  long long every = 0;                ///< steps between the commands; 0: none
  std::vector<std::string> commands;  ///< after each `every`

  /// Last step of the part between two commands that `step` lies in (step < end).
  long long part_end(long long step) const;
  long long part_begin(long long step) const;
  /// The words of `run` for the steps from `step` to `to`: what stands between the commands is a run of its own, and
  /// ramps go over all of it, however it is cut.
  std::vector<std::string> words(long long step, long long to, bool set_up) const;
};

/// words: the command's name and its words; dt (s). Nothing: LIGGGHTS itself has to say what is wrong with them.
std::optional<RunRequest> run_request(const std::vector<std::string>& words, long long step, double dt);

}  // namespace twogrid
