// A part of the exchange between fluid and particles beside drag and pressure: lift, heat, ... A model is one file with
// its equations; it is asked twice a coupling, and loops over particles itself.
//
//   give   before the fluid advances: what the particles have for it in the interval (Reader::react(), collect())
//   take   after it: what particles read now (Reader::load(), at()), in the interval to come a force of their own, steady
//          over it, added to kPressureForce. The coupling gives the fluid the opposite of every force's impulse by
//          itself.
//
// What a model keeps from one coupling to the next belongs into the state: fields of the fluid's cells by
// FluidSolver::add_field(), numbers and arrays by CouplingState::models.
#pragma once

#include <mpi.h>

#include <vector>

#include "coupling/coupling_state.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/reader.h"

namespace twogrid {

class Fluid;

/// What a model works on. Lists belong to the particles `who`, those inside the fluid's domain.
struct ExchangeSite {
  MPI_Comm comm;
  Particles& p;
  const std::vector<int>& who;
  const Places& places;  ///< of `who` in the reader
  Reader& reader;        ///< its groups are the model's to load, its reaction to clear and collect
  const Fluid& fluid;
  const CellField<FineGrid>& eps;  ///< void fraction of own fine cells and a halo, at the coupling
  double interval;                 ///< D (s); of the one to come in the first coupling
  double terms;                    ///< particles that a node can hold: bounds sums (FixedPoint)
  CouplingState& state;
};

class ExchangeModel {
 public:
  virtual ~ExchangeModel() = default;
  /// take() adds forces: the particles' columns kPressureForce are in use.
  virtual bool forces() const { return false; }
  /// Both collective.
  virtual void give(const ExchangeSite&) {}
  virtual void take(const ExchangeSite&) {}
};

}  // namespace twogrid
