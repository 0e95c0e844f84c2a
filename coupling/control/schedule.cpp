#include "coupling/control/schedule.h"

namespace twogrid {

void Schedule::count_step(long long step, double dt, int every) {
  ++state_.steps;
  state_.time += dt;
  coupling_ = every_changes_ ? state_.steps >= every : step % every == 0;
}

void Schedule::end_interval() {
  state_.interval = state_.time;
  state_.steps = 0;
  state_.time = 0;
}

long long Schedule::count_particles(long long now) {
  if (state_.particles > now) state_.lost += state_.particles - now;
  state_.particles = now;
  if (state_.lost <= 2 * state_.told) return 0;
  return state_.told = state_.lost;
}

}  // namespace twogrid
