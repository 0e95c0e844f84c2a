// What is left of -grad p when the particles' reaction is taken out: the fluid's inertia and viscous force per volume
// of fluid. From the fluid's momentum balance of the last interval, on each solved face:
//   R_new = -(grad p - source + beta u) / eps,     grad p and u: means over the interval
//   R <- R + w (R_new - R),     w = eps/(1 + eps_s rho_f/rho_p)
// The weight stands for an implicit treatment of two feedbacks that an explicit R would amplify. Added mass: a light
// particle accelerates the fluid around it, whose inertia acts back on it, by -(eps_s/eps) rho_f/rho_p a coupling. And
// where drag is weak: the fluid hands the share eps_s R of its inertia to the particles and answers with an
// acceleration opposite to it, by -eps_s/eps; with w both settle without swinging. The steady state doesn't depend on
// w. Formulation A rebuilds the pressure force of a particle from it: V_p (R + D/eps), D: drag per volume
// (mean_motion.h).
#pragma once

#include <mpi.h>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/block_exchange.h"
#include "coupling/particles/particles.h"

namespace twogrid {

/// Of the particles in `who` of all ranks, kg/m3; without any: the other one. Collective.
double mean_density(MPI_Comm comm, const Particles& p, const std::vector<int>& who, double otherwise);

class UndisturbedForce {
 public:
  /// r: N/m3, own faces and a halo of one; zero to begin with. Collective.
  UndisturbedForce(MPI_Comm comm, const Fluid& fluid, FaceField<FineGrid>& r);

  /// eps: cells, halo included. exchange: of the interval just advanced; its fields may be empty. Collective.
  void update(const Fluid& fluid, const CellField<FineGrid>& eps, const Interphase& exchange, double particle_density);

  const FaceField<FineGrid>& field() const { return r_; }

 private:
  template <bool kOpenShares>
  void renew(const Fluid& fluid, const CellField<FineGrid>& eps, const Interphase& exchange, double particle_density);

  std::array<Box, 3> own_;
  FaceField<FineGrid>& r_;
  std::vector<double> source_, beta_;  // scratch: rows of the exchange
  FaceExchange halo_;
};

}  // namespace twogrid
