// The coupling: particles and fluid, seen through two small interfaces (Particles, Fluid), advanced by turns.
//
// At a DEM step that is a multiple of `every` (t^n), with the particles at x(t^n):
//   1 deposit   V_p            -> eps_s on the particle grid -> bounded -> eps on the fine grid
//   2 react     impulses that the particles received in the interval -> source of the fluid, by the transpose of read;
//               beta_eff = sum w_pf b'_p / V_f,  b'_p = (m_p/Dt) (1 - exp(-b_p Dt/m_p)): what a change of u by du over
//               the interval would have given the particle is b'_p Dt du. Intervals not short against the
//               response time m_p/b_p: also the drag of the fluid's own deviation from what particles read
//   3 advance   the fluid over the interval, t^{n-1} -> t^n, in as many steps as it needs
//   4 kick      what the implicit part changed, b'_p (u_read - u_seen) Dt, goes to the particles at once: the sum of
//               momenta of fluid and particles is kept to round-off
//   5 read      u, grad p, eps at the particles; b_p by the drag law
// Then, at every DEM step: force() adds drag (exponential integrator), pressure gradient force and buoyancy.
//
// Order in a DEM step: half kick and drift, advance() if it is a coupling step, all other forces, force(), half kick.
// So at advance() v is the velocity that carried the particles to x(t^n), and all earlier forces are in it in full. In
// set-up: start(), then force() with accumulate = false.
#pragma once

#include <mpi.h>

#include <memory>
#include <string>

#include "coupling/particles/particles.h"
#include "coupling/report.h"
#include "coupling/settings.h"

namespace twogrid {

class ExchangeModel;
class Fluid;
class OpenNodes;
struct CouplingState;

/// CPU seconds of this rank by part.
struct Shares {
  double deposit = 0, map = 0, fluid = 0, output = 0, force = 0;
};

class Coupling {
 public:
  /// Collective. sub_lo, sub_hi: this rank's brick of the particle decomposition; reach: how far outside it a particle
  /// may lie (half a skin). Throws std::invalid_argument with a sentence for settings that can't be served.
  Coupling(MPI_Comm comm, const Settings& settings, Fluid& fluid, const Vec3& sub_lo, const Vec3& sub_hi, double reach);
  ~Coupling();

  /// At the beginning of every run. The first: deposits, initialises eps^n and eps^{n-1}, and reads; the fluid does not
  /// advance. Later ones: fluid and particles replace each other, without motion, where commands have deleted, moved or
  /// resized particles since rest(). Collective.
  void start(Particles& p, double dem_dt);
  /// At the end of every run: whatever changes until start() has been changed by commands. Collective.
  void rest(Particles& p);
  /// Between rest() and start().
  bool resting() const;
  /// The rank's brick of the particle decomposition has become another; between couplings. Collective.
  void move_region(const Vec3& sub_lo, const Vec3& sub_hi, double reach);
  /// Steps 1-5 above for an interval of `steps` DEM steps of dem_dt seconds. Collective.
  /// check: also measures step_error and coupling_error; the result is the same.
  void advance(Particles& p, int steps, double dem_dt, bool check = false);
  /// Every DEM step, after all other forces: f += drag + pressure gradient force + buoyancy, by an exponential
  /// integrator; sums up impulses. Collective only while holding the flux. accumulate = false in set-up: forces only.
  void force(Particles& p, double dem_dt, bool accumulate = true);

  /// In place of force() at a step that differs in nothing from the one before (Particles::still): its impulse is
  /// counted, f is left alone.
  void repeat_force();

  /// At the end of every DEM step, after the last half kick: turns the force into that of the next half kick. Does
  /// nothing for particles whose response time is long against the DEM step (StepForces::kStiff). Not in set-up. Local.
  void finish_step(Particles& p);
  /// Before the first start().
  void add_model(std::unique_ptr<ExchangeModel> model);
  /// For the buoyancy -V_p rho_f g: p is the dynamic pressure, its hydrostatic part is not in the fluid's equations. Not
  /// called: none.
  void set_gravity(const std::vector<Weight>& weights);

  /// All that the next interval takes from those before, apart from the particles' columns and the fluid; of this rank,
  /// between couplings. May be replaced by a copy, which another coupling of the same settings can have made.
  CouplingState& state();
  /// Figures of the last coupling, to be filled beside state().
  Report& report_to_restore();
  /// state() holds what another coupling left between two runs: the report tells of it, and start() goes on from it.
  void restored();
  const Report& report() const;
  /// Where bodies stand: what they make of the particle grid; null: there are none.
  const OpenNodes* open_nodes() const;
  /// Particles whose centre lies in a closed cell of the fluid, of all ranks. Collective.
  long long in_closed_cells(const Particles& p) const;
  const Shares& shares() const;
  Fluid& fluid();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twogrid
