// From the particles to the void fraction that the fluid sees: deposit, bound, prolong, and how it runs in time.
//
//   deposit()       V_p -> solid volume of the nodes -> bounded (solid_limit.h) -> eps of the nodes -> prolonged to the
//                   fine grid: eps at the interval's end (void_history.h)
//   replacement()   what particles that came, and commands between runs, change at once at the interval's begin
//   rest(), go_on() what lies between two runs: where commands have deleted particles, made them smaller or moved them
//                   away, fluid takes their place at the next coupling, and the other way round
#pragma once

#include <mpi.h>

#include "cfd/fluid/fluid.h"
#include "coupling/coupling_state.h"
#include "coupling/particles/ledger.h"
#include "coupling/selection/census.h"
#include "coupling/selection/selection.h"
#include "coupling/settings.h"
#include "coupling/two_grid/prolongation.h"
#include "coupling/void_fraction/solid_limit.h"
#include "coupling/void_fraction/void_history.h"
#include "coupling/void_fraction/volume_deposit.h"

namespace twogrid {

class VoidFraction {
 public:
  /// Works on state.history, .deposit and .change. Collective.
  VoidFraction(CouplingState& state, MPI_Comm comm, const Settings& settings, const Fluid& fluid,
               const ParticleGrid& nodes, const ParticleRegion& region);

  /// Collective.
  void move_region(const ParticleRegion& region) { deposit_.move_region(region); }
  /// Fills history().next(), halo included. places: of selection.inside() where particles read. Throws
  /// std::runtime_error where the particles leave no room. Collective.
  void deposit(const Particles& p, const Selection& selection, const Places& places, const Census& census,
               Ledger& ledger);
  /// Change of eps at the interval's begin, for history().begin(), and exchange's flags of it; null: none. After
  /// deposit(). Collective.
  const CellField<FineGrid>* replacement(const Particles& p, const Selection& selection, const Census& census,
                                         Interphase& exchange);
  VoidHistory& history() { return history_; }
  /// state.deposit has been filled, perhaps by another number of ranks.
  void restored();

  /// selection: of now. Collective.
  void rest(const Particles& p, const Selection& selection);
  void go_on(const Particles& p, const Selection& selection);

 private:
  void check_room() const;
  void hand_down(CellField<ParticleGrid>& node) const;
  void allocate_replacement();
  void lay_out(const Particles& p, const Selection& selection, CellField<ParticleGrid>& eps);

  DepositState& state_;
  ChangeState& change_;
  MPI_Comm comm_;
  Settings settings_;
  FineGrid grid_;
  ParticleGrid nodes_;
  const OpenShares* open_;  // of the fluid
  Box own_cells_, own_nodes_;
  bool same_places_;  // deposit and read have the same weights
  VoidHistory history_;
  VolumeDeposit deposit_;
  SolidLimit limit_;
  Prolongation prolongation_;
  // Scratch; the last three from when first needed.
  Array3<long long> solid_, inserted_;
  CellField<ParticleGrid> replaced_;
  CellField<FineGrid> replaced_cells_;
};

}  // namespace twogrid
