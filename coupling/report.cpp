#include "coupling/report.h"

namespace twogrid {

void Report::take(const CouplingState& state, const Census& census, const Ledger::Balance& balance, double vanished) {
  solid_volume_error = balance.volume_error;
  volume_inserted = balance.inserted_volume;
  volume_vanished = vanished;
  particles = census.particles;
  in_walls = census.in_walls, behind_walls = census.behind_walls, tag_behind = census.tag_behind;
  solid_volume = state.known_volume;
  inserted_total = state.inserted, vanished_total = state.vanished, grown_total = state.all_grown;
  volume_moved = state.deposit.volume_moved, volume_unplaced = state.deposit.volume_unplaced;
  max_drag_number = state.drag_number;
  holding_flux = state.holding;
  pressure_force = state.step.pressure_force;
}

void Report::take(const CouplingState& state, double time) {
  fluid_time = time;
  fluid_steps = state.fluid_steps;
  solid_volume = state.known_volume;
  inserted_total = state.inserted, vanished_total = state.vanished, grown_total = state.all_grown;
  volume_moved = state.deposit.volume_moved, volume_unplaced = state.deposit.volume_unplaced;
}

std::array<double, Report::kValues> Report::values(int every) const {
  return {fluid_time,         fluid_dt,       cfl,           pressure_drop,  divergence_error,
          solid_volume_error, momentum_error, volume_moved,  eps_min,        double(pressure_iterations),
          step_error,         coupling_error, double(every), inserted_total, vanished_total,
          grown_total};
}

void Report::take(const FluidReport& fluid, double time, long long steps) {
  fluid_time = time;
  fluid_dt = fluid.dt;
  cfl = fluid.cfl;
  pressure_drop = fluid.pressure_drop;
  divergence_error = fluid.divergence_error;
  pressure_iterations = fluid.pressure_iterations;
  fluid_steps = steps;
}

}  // namespace twogrid
