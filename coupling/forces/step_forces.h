// The fluid's forces on the particles at a DEM step, from what they read at the last coupling.
//
// Drag with the exact answer of a linear drag to a constant force (exponential integrator): velocity Verlet moves
// v^{n-1/2} to v^{n+1/2} by one f,
//   f <- phi(k) (f - V_p rho_f g + F),   F = b (u_seen - v) + F_p,   k = c D/m,   phi(k) = (1 - e^-k)/k,   D = dem_dt
//   not holding   u_seen = u_read, c = b
//   holding       u_seen = u_read - C(t), c = b_tot (1 + eps_s/eps); with a pressure force: F_p grows by V_p P(t)
//   a component that something holds: phi = 1
// monotone for every k. Where k > kStiff each half kick has a force of its own, with b by the drag law at the mean
// slip.
#pragma once

#include <vector>

#include "coupling/coupling_state.h"
#include "coupling/forces/drag.h"
#include "coupling/forces/mean_motion.h"
#include "coupling/particles/decay.h"
#include "coupling/particles/particles.h"
#include "coupling/settings.h"

namespace twogrid {

class StepForces {
 public:
  /// Works on `state`.
  StepForces(StepForcesState& state, const DragLaw& law, double density, double viscosity)
      : state_(state), law_(law), density_(density), viscosity_(viscosity) {}

  /// For the buoyancy. Looked at particle by particle only where one is not of all.
  void set_gravity(const std::vector<Weight>& weights);
  /// Adds to f; sums up impulses. holding: the particles' mean motion, now, where the flux is held; else null.
  /// accumulate = false in set-up: the impulse of half a step, in place of the half step the last one would have had.
  /// There v is that of a whole step. Where a run goes on with the step that the last one had, v^n came of
  /// v^{n-1/2} and the same f: f = phi/(1 - phi b D/2m) (...) with v^n gives that f again.
  /// Local.
  void operator()(Particles& p, double dem_dt, bool accumulate, MeanMotion* holding);
  /// The force of the next half kick, after a step that was stiff. Local.
  void finish_step(Particles& p) const;
  /// The mass of particle i has become another. Local.
  void renew_decay(Particles& p, int i) const { p.step[i][kDecay] = decay(p.step[i][kDragCoefficient], 1 / p.mass[i]); }
  /// kDecay of a particle: phi(b D/m) of the DEM step of the last call; 0 where it has to be looked at closer.
  double decay(double b, double per_mass) const {
    const double k = b * state_.decay_dt * per_mass;
    return b > 0 && k <= kStiff ? mean_decay_series(k) : 0.0;
  }
  double decay_dt() const { return state_.decay_dt; }

 private:
  template <bool kHolding, bool kHeld>
  void on_all(Particles& p, double dem_dt, bool accumulate, MeanMotion* holding);
  void plain(Particles& p, double dem_dt);
  void find_decay(Particles& p, double dem_dt);
  template <bool kHolding, bool kHeld>
  void on(Particles& p, int i, double dem_dt, bool accumulate, MeanMotion* holding);
  double law_at(const Particles& p, int i, const Vec3& slip) const;
  void stiff_forces(const Particles& p, int i, double k_per_b, const Vec3& per_mass, const Vec3& steady,
                    const Vec3& slip, bool ends_a_step, Vec3& first, Vec3& second) const;
  Vec3 gravity_of(const Particles& p, int i) const;

  StepForcesState& state_;
  const DragLaw& law_;
  double density_, viscosity_;
  Vec3 gravity_{0, 0, 0};  // of all particles, where by_group_ is empty
  std::vector<Weight> by_group_;
  std::vector<int> stiff_;  // particles of the last step, for finish_step()
  std::vector<int> left_;   // by add_plain_forces()
};

}  // namespace twogrid
