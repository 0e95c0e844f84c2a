// The particles' mean motion and drag on the particle grid, and what follows from it during a coupling interval.
//
// Volume conservation ties the fluid's velocity to the particles' mean motion: over an interval the volume flux
// j = eps u + eps_s v_mean is what stays, not u. With the sums over a node's particles (weights w)
//   v(t)   = sum w m v / sum w m               now
//   v_n                                        the same at the last coupling
//   v_flux                                     of the velocity that the continuity equation saw at the last coupling
//   beta   = sum w b_A / V,  D_n = sum w b_A (u - v) / V   at the last coupling (b_A: formulation A's drag coefficient)
// the fluid velocity that a particle sees at time t is
//   u_seen = u_read - C,     C = (eps_s (v(t) - v_flux) - J)/eps
// and in formulation A the part of -grad p that balances the drag, D/eps, is
//   D(t)/eps = D_n/eps + P,  P = -(beta/eps) (C + v(t) - v_n).
// J: where nothing holds the net flux through the domain (periodic directions without a given flow rate), it is the
// domain's mean of eps_s (v(t) - v_flux), so that only what continuity really ties is held; else zero.
#pragma once

#include <mpi.h>

#include <vector>

#include "cfd/parallel/vectorised.h"
#include "coupling/coupling_state.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/map.h"
#include "coupling/two_grid/window.h"

namespace twogrid {

class MeanMotion {
 public:
  /// Works on `state`. spread: kCell or kLinear. free_flux: directions in which nothing holds the net flux. Collective.
  MeanMotion(MeanMotionState& state, MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes,
             const ParticleRegion& region, Spread spread, const std::array<bool, 3>& free_flux);

  /// Particles are elsewhere now; what they read comes with the next update(). Collective.
  void move_region(const ParticleRegion& region);

  /// Largest values of this coupling, over all ranks; `terms` bounds how many particles a node's sum can hold.
  struct Largest {
    double mass = 0, momentum = 0, drag_coefficient = 0, drag = 0, terms = 1;
  };

  /// Sauter mean diameter of each node, readable with diameter(). Collective.
  void average_diameters(const Particles& p, const std::vector<int>& who, double largest_radius, double terms);
  double diameter(const double x[3]) const;

  /// Sums of the particles in `who` at a coupling. flux_velocity[q] belongs to who[q]. eps: own nodes.
  /// drag: beta and D_n are wanted (formulation A). Collective.
  void couple(const Particles& p, const std::vector<int>& who, const std::vector<FourNumbers>& flux_velocity,
              const CellField<ParticleGrid>& eps, const Largest& largest, bool drag);
  /// beta/eps (kg/(m3 s)) and D_n/eps (N/m3) at a particle, after couple() with drag.
  void drag_at(const double x[3], double& beta, Vec3& d) const;

  /// The particles have moved: v(t), C and P. A particle counts if it feels drag. eps: as in couple(). Collective.
  void update(const Particles& p, const CellField<ParticleGrid>& eps);
  /// C (m/s) and P (N/m3; zero without drag) at a particle, after update().
  void change_at(const double x[3], Vec3& c, Vec3& pressure) const;

 private:
  /// Sums over a node's particles: of the motion, components 0-2 momentum, 3 mass; of the velocity that continuity sees,
  /// momentum; of the drag, force and coefficient.
  enum { kMotion, kFlux, kDrag, kSums };

  /// f(place): of a particle at x. kCut: bodies stand in the grid.
  template <bool kCut, class F>
  void at(const double x[3], F f) const {
    if (kCut && window_.spread() == Spread::kCell) {
      f(window_.open_node(x));
    } else if (kCut) {
      window_.see(x, seen_);
      f(seen_);
    } else if (window_.spread() == Spread::kCell) {
      f(window_.node(x));
    } else {
      f(window_.corners(x));
    }
  }
  void clear(int sums);
  void sum_motion(const Particles& p, const std::vector<int>* who);
  template <bool kCut>
  void add_motion(const Particles& p, const std::vector<int>* who);
  template <bool kCut>
  void add_flux_and_drag(const Particles& p, const std::vector<int>& who, const std::vector<FourNumbers>& flux_velocity,
                         const Largest& largest, bool drag);
  void collect(int sums);
  /// Brings so many groups a node from own_shown_ to shown_.
  void bring(int groups);
  FourNumbers& own_shown(int i, int j, int k, int group, int groups) {
    return own_shown_[groups * place(i, j, k) + group];
  }
  /// Place of an own node.
  std::size_t place(int i, int j, int k) const {
    return (i - own_.lo[0]) +
           std::size_t(own_.size(0)) * ((j - own_.lo[1]) + std::size_t(own_.size(1)) * (k - own_.lo[2]));
  }

  MeanMotionState& state_;
  MPI_Comm comm_;
  ParticleGrid grid_;
  Layout nodes_;
  Box own_;
  Spread spread_;
  Window window_;
  WindowShape shape_;
  mutable SeenNodes seen_{};  // scratch, where bodies stand
  std::array<bool, 3> free_flux_;
  double domain_volume_;
  FixedPoint mass_unit_, momentum_unit_;
  std::array<std::vector<FourWholeNumbers>, kSums> window_sum_, node_sum_;  // on the window, of own nodes
  std::vector<FourNumbers> own_shown_, shown_;  // what particles read: of own nodes, on the window
};

}  // namespace twogrid
