#include "liggghts_fixes/run/signals.h"

#include <csignal>
#include <cstdlib>
#include <ctime>

namespace twogrid {
namespace {

// A handler can reach nothing but an object of static duration.
volatile std::sig_atomic_t first_signal = 0;
volatile std::time_t first_time = 0;

extern "C" void take_signal(int number) {
  if (first_signal == 0) {
    first_signal = number;
    first_time = std::time(nullptr);
  } else if (number == SIGINT && first_signal == SIGINT && std::time(nullptr) > first_time) {
    std::_Exit(128 + number);
  }
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action = {};
  action.sa_handler = take_signal;
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGINT, SIGTERM, SIGUSR1}) sigaction(number, &action, nullptr);
}

int signal_seen() {
  return first_signal;
}

}  // namespace twogrid
