// The state of the coupling: all that one interval leaves to the next, apart from the particles' own columns
// (particles.h) and the fluid's state (cfd/fluid/fluid_state.h). What is not here is made anew in every interval, or
// follows from the settings. Figures for the user (Report) are written from it, never read. A copy of the struct is a
// checkpoint in memory, of this rank; for_each_entry() walks it by name.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cfd/grid/field.h"
#include "cfd/grid/state_entries.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

/// The void fraction on the fine grid at the last coupling, and how it came there (void_history.h).
struct VoidHistoryState {
  CellField<FineGrid> now;                // eps^n
  CellField<FineGrid> rate, slope_begin;  // s_n, slope at the begin of the interval to come (1/s); only if smooth
  double interval = 0;                    // D_n (s); 0: there was none
};

/// The particles' mean motion and drag at the last coupling (mean_motion.h). Own nodes, from when first needed.
struct MeanMotionState {
  bool drag = false;             // beta is there
  double mass = 0, terms = 1;    // bounds of the sums: largest mass (kg), particles a node can hold
  CellField<ParticleGrid> beta;  // beta/eps (kg/(m3 s))
  std::array<CellField<ParticleGrid>, 3> v_flux, v_n;  // m/s
};

/// What the forces of a DEM step leave to the next (step_forces.h).
struct StepForcesState {
  bool pressure_force = false;  // the pressure's is a force of its own, and b is b_p; else b is b_p/eps
  bool own_force = false;       // F_p is in use: the pressure's, or models'; else it is zero
  double last_dt = 0;           // DEM step of the last call that was no set-up (s); 0: none yet
  double decay_dt = 0;          // DEM step of the particles' kDecay (s); 0: none yet
};

/// The deposit of the last coupling (void_fraction.h).
struct DepositState {
  CellField<ParticleGrid> eps;                   // void fraction on own nodes and a halo of one
  double largest_radius = 0;                     // of all particles (m)
  double eps_min = 1;                            // of own nodes; follows from eps
  double volume_moved = 0, volume_unplaced = 0;  // m3
  double volume = 0;                             // of own cells (m3)
  bool still = false;                            // nothing moved: it may be that of the next coupling too
  long long particles = 0;                       // of all ranks
};

/// Changes by commands between runs (void_fraction.h).
struct ChangeState {
  bool resting = false;              // between runs
  CellField<ParticleGrid> rest_eps;  // as the particles lay when the last run ended; only if resting
  bool changed = false;              // since the last coupling
  CellField<FineGrid> eps;           // what commands have added to eps; only if changed
};

/// What a model of the exchange keeps (exchange_model.h). Arrays are the rank's: own nodes.
struct ModelState {
  std::string name;  // of the entry
  double number = 0;
  CellField<ParticleGrid> field;
};

struct CouplingState {
  bool started = false;
  bool holding = false;     // the flux is held
  double drag_number = 0;   // largest interval over response time at the last coupling
  double follow = 0;        // largest time to cross what is read over response time, then
  double known_volume = 0;  // of the particles at the last coupling (m3)
  double grown = 0;         // volume that this rank's particles have gained since (m3)
  int repeated = 0;         // steps since whose force was that of the step before
  VoidHistoryState history;
  DepositState deposit;
  ChangeState change;
  FaceField<FineGrid> undisturbed;  // R (N/m3), own faces and a halo of one; formulation A only
  MeanMotionState motion;
  StepForcesState step;
  std::vector<ModelState> models;
  // Over the run.
  long long fluid_steps = 0;
  double inserted = 0, vanished = 0, all_grown = 0;  // volumes (m3)

  /// Calls f(name, entry) for every entry, in an order that is always the same; entry: double&, int&, long long&, bool&
  /// or Array3<double>& (of size 0 where not in use). S: CouplingState or const CouplingState.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("started", s.started), f("holding", s.holding), f("drag_number", s.drag_number), f("follow", s.follow);
    f("known_volume", s.known_volume), f("grown_of_rank", s.grown), f("repeated", s.repeated);
    show_array("history_now", s.history.now, f), show_array("history_rate", s.history.rate, f);
    show_array("history_slope", s.history.slope_begin, f), f("history_interval", s.history.interval);
    show_array("deposit_eps", s.deposit.eps, f), f("deposit_largest_radius", s.deposit.largest_radius);
    f("deposit_moved", s.deposit.volume_moved);
    f("deposit_unplaced", s.deposit.volume_unplaced), f("deposit_volume_of_rank", s.deposit.volume);
    f("deposit_still", s.deposit.still), f("deposit_particles", s.deposit.particles);
    f("change_resting", s.change.resting), show_array("change_rest_eps", s.change.rest_eps, f);
    f("change_changed", s.change.changed), show_array("change_eps", s.change.eps, f);
    show_components(s.undisturbed, {"undisturbed_x", "undisturbed_y", "undisturbed_z"}, f);
    f("motion_drag", s.motion.drag), f("motion_mass", s.motion.mass), f("motion_terms", s.motion.terms);
    show_array("motion_beta", s.motion.beta, f);
    show_components(s.motion.v_flux, {"motion_v_flux_x", "motion_v_flux_y", "motion_v_flux_z"}, f);
    show_components(s.motion.v_n, {"motion_v_n_x", "motion_v_n_y", "motion_v_n_z"}, f);
    f("step_pressure_force", s.step.pressure_force), f("step_last_dt", s.step.last_dt);
    f("step_decay_dt", s.step.decay_dt), f("step_own_force", s.step.own_force);
    for (auto& m : s.models) f(m.name.c_str(), m.number), show_array((m.name + "_field").c_str(), m.field, f);
    f("fluid_steps", s.fluid_steps), f("inserted", s.inserted), f("vanished", s.vanished);
    f("all_grown", s.all_grown);
  }
};

}  // namespace twogrid
