// Implicit viscosity: A u V - integral of div(eps tau(u)) = rhs, for the three components together, by PETSc's
// conjugate gradients with a diagonal preconditioner (options prefix -fluid_momentum_). Matrix-free.
#pragma once

#include <mpi.h>

#include <array>
#include <memory>

#include "cfd/boundary/boundaries.h"
#include "cfd/grid/field.h"
#include "cfd/momentum/viscous_stress.h"
#include "cfd/parallel/block_exchange.h"

namespace twogrid {

class ViscousSolver {
 public:
  /// Collective. The references must outlive the solver.
  ViscousSolver(MPI_Comm comm, const Boundaries& boundaries, const GridMeasures& measures, ViscousTerm& stress,
                const std::array<Box, 3>& faces, const Box& local, const FaceExchange& halo);
  ~ViscousSolver();

  /// inertia: A (kg/(m3 s)), rhs (N), own faces; u on entry: first guess with prescribed faces set, on return: the
  /// solution. Collective. Throws std::runtime_error with a sentence on all ranks when it doesn't converge.
  int solve(const Property& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& inertia,
            const FaceField<FineGrid>& rhs, FaceField<FineGrid>& u);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twogrid
