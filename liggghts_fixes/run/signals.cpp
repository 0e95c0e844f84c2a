#include "liggghts_fixes/run/signals.h"

#include <signal_handling.h>

#include <csignal>
#include <cstdlib>

namespace twogrid {
namespace {

// A handler can reach nothing but an object of static duration.
volatile std::sig_atomic_t first_signal = 0, listeners = 0;

extern "C" void take_signal(int number) {
  if (listeners == 0) return LAMMPS_NS::SignalHandler::int_handler(number);
  if (first_signal != 0) std::_Exit(128 + number);
  first_signal = number;
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action = {};
  action.sa_handler = take_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction restart = {};
  restart.sa_handler = LAMMPS_NS::SignalHandler::usr1_handler;
  sigaction(SIGUSR1, &restart, nullptr);
}

void add_signal_listener(int change) {
  listeners = listeners + change;
}

int signal_seen() {
  return first_signal;
}

}  // namespace twogrid
