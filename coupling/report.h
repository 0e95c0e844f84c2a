// What the coupling tells of itself. Written from the state, never read by it.
#pragma once

#include <array>

#include "cfd/fluid/fluid.h"
#include "coupling/coupling_state.h"
#include "coupling/particles/ledger.h"
#include "coupling/selection/census.h"

namespace twogrid {

/// Figures of the last coupling and of the run so far; the same on all ranks. f_ID[1..10] are the first ten, in
/// this order; f_ID[11..15]: see FixTwogrid::compute_vector.
struct Report {
  double fluid_time = 0, fluid_dt = 0, cfl = 0, pressure_drop = 0, divergence_error = 0;
  double solid_volume_error = 0;  ///< relative: deposited against the particles' own
  double momentum_error = 0;      ///< relative: action against reaction
  double volume_moved = 0;        ///< by the eps bound, m3 (bound clip: thrown away)
  double eps_min = 1;
  int pressure_iterations = 0;
  long long fluid_steps = 0;
  double max_drag_number = 0;  ///< largest beta Dt/(rho_p eps_s): interval over response time
  bool holding_flux = false;
  /// Particles feel the pressure gradient as a force of its own (A, or sizes that differ).
  bool pressure_force = false;
  double solid_volume = 0;  ///< m3, of the particles that take part
  long long particles = 0;
  double volume_inserted = 0;                     ///< of particles new since the last coupling (m3); they replace fluid
  double volume_vanished = 0;                     ///< of particles deleted, or gone out of the domain, since then (m3)
  double inserted_total = 0, vanished_total = 0;  ///< their sums over the run (m3)
  double grown_total = 0;      ///< volume by which particles have become larger, or (negative) smaller, so far (m3)
  double travel = 0;           ///< largest way of a particle in an interval, at its speed now, in particle cells
  double volume_unplaced = 0;  ///< above the eps bound, with no room anywhere (m3)
  /// Where bodies stand: particles whose centre lies in a closed particle cell, with the fluid of the nearest open one;
  /// and those that lie deeper in a body, as if outside the fluid.
  long long in_walls = 0, behind_walls = 0;
  long long tag_behind = -1;  ///< of one of the latter
  double step_error = 0;      ///< of the last check: Fluid::advance_and_check
  double coupling_error = 0;  ///< of the last check: half the change of the fluid's forces on the particles at the
                              ///< coupling, root mean square over that of the forces themselves

  /// What a coupling has left in the state. volume_vanished since the last one (m3).
  void take(const CouplingState& state, const Census& census, const Ledger::Balance& balance, double vanished);
  /// What restored states tell of the runs before; the entries below come on top.
  void take(const CouplingState& state, double time);
  /// What the fluid says of an interval that ended at fluid_time.
  void take(const FluidReport& fluid, double time, long long steps);

  /// f_ID[1], f_ID[2], ...
  static constexpr int kValues = 16;
  std::array<double, kValues> values(int every) const;

  /// Figures of the last coupling that no state holds and that are asked for until the next: f(name, entry). R: Report or
  /// const Report.
  template <class R, class F>
  static void for_each_entry(R& r, F&& f) {
    f("fluid_dt", r.fluid_dt), f("cfl", r.cfl), f("pressure_drop", r.pressure_drop);
    f("divergence_error", r.divergence_error), f("solid_volume_error", r.solid_volume_error);
    f("momentum_error", r.momentum_error), f("eps_min", r.eps_min), f("pressure_iterations", r.pressure_iterations);
    f("step_error", r.step_error), f("coupling_error", r.coupling_error);
  }
};

}  // namespace twogrid
