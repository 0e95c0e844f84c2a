// SIGINT, SIGTERM and SIGUSR1 end a run cleanly: a flag is set, which all ranks look at together (early_end.h).
#pragma once

#include <stdexcept>
#include <string>

namespace twogrid {

/// Installs the handlers. Of the signals that come after the first only a second SIGINT, a second later, counts: it ends
/// the process at once. A batch system sends the others to several processes of a job, and more than once.
void install_signal_handlers();
/// Thrown where a run can't go on to its next step in time.
struct EndedBySignal : std::runtime_error {
  EndedBySignal(int signal, const std::string& sentence) : std::runtime_error(sentence), number(signal) {}
  int number;
};

/// Number of the first signal that came, or 0. This rank's only.
int signal_seen();

}  // namespace twogrid
