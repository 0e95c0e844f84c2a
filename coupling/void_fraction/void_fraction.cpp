#include "coupling/void_fraction/void_fraction.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

VoidFraction::VoidFraction(CouplingState& state, MPI_Comm comm, const Settings& settings, const Fluid& fluid,
                           const ParticleGrid& nodes, const ParticleRegion& region)
    : state_(state.deposit),
      change_(state.change),
      comm_(comm),
      settings_(settings),
      grid_(fluid.grid()),
      nodes_(nodes),
      open_(fluid.open_shares()),
      own_cells_(fluid.layout().cells(rank_of(comm))),
      own_nodes_(node_layout(fluid.layout(), nodes).cells(rank_of(comm))),
      same_places_((settings.deposit == Deposit::kTrilinear && settings.read == Read::kTrilinear) ||
                   (settings.deposit == Deposit::kCentroid && settings.read == Read::kCell)),
      history_(state.history, fluid.void_fraction().box(), settings.interpolate),
      deposit_(comm, nodes, node_layout(fluid.layout(), nodes), region, settings.deposit, settings.cube_edge),
      limit_(comm, nodes, node_layout(fluid.layout(), nodes), settings.bound, settings.eps_min),
      prolongation_(comm, fluid.grid(), fluid.layout(), nodes, settings.prolong, settings.eps_min) {
  solid_.reset(own_nodes_);
  state_.eps.reset(own_nodes_.empty() ? own_nodes_ : own_nodes_.grown(1), 1.0);
}

void VoidFraction::deposit(const Particles& p, const Selection& selection, const Places& places, const Census& census,
                           Ledger& ledger) {
  CellField<FineGrid>& fine = history_.next();
  state_.largest_radius = census.radius;
  if (settings_.one_way) {  // the fluid doesn't know of the particles
    fine.fill(1.0);
    ledger.deposited_volume = ledger.particle_volume;
    return;
  }
  // What follows from positions alone stays, where nothing moves, came or went.
  const bool keep = p.still && state_.still && census.new_particles == 0 && census.particles == state_.particles;
  state_.still = p.still;
  state_.particles = census.particles;
  if (keep) {
    fine = history_.now();
    ledger.deposited_volume += state_.volume;
    return;
  }
  deposit_.prepare(census.radius);
  deposit_(p, selection.inside(), solid_, same_places_ ? &places : nullptr);
  const FixedPoint& scale = deposit_.scale();
  const SolidLimit::Result limited = limit_(scale, solid_);
  state_.volume_moved = limited.displaced;
  state_.volume_unplaced = limited.unplaced;
  double eps_min = 1;
  for_each(own_nodes_, [&](int i, int j, int k) {
    const double eps = 1 - nodes_.share_of(scale.value(solid_(i, j, k)), i, j, k);
    state_.eps(i, j, k) = eps;
    eps_min = std::min(eps_min, eps);
  });
  state_.eps_min = eps_min;
  hand_down(state_.eps);
  if (limited.unplaced > 0) check_room();  // else no node is above the bound
  prolongation_(state_.eps, fine);
  if (open_)
    for_each(own_cells_, [&](int i, int j, int k) {
      ledger.deposited_volume += (1 - fine(i, j, k)) * (open_->theta()(i, j, k) * grid_.volume(i, j, k));
    });
  else
    for_each(own_cells_,
             [&](int i, int j, int k) { ledger.deposited_volume += (1 - fine(i, j, k)) * grid_.volume(i, j, k); });
  state_.volume = ledger.deposited_volume.value();
}

/// A value of families, from where it was made to all members.
void VoidFraction::hand_down(CellField<ParticleGrid>& node) const {
  if (const OpenNodes* open = nodes_.open_nodes()) open->hand_down(slot_of<double>(node));
}

void VoidFraction::restored() {
  state_.eps_min = 1;
  if (state_.eps.size() == 0) return;
  for_each(own_nodes_, [&](int i, int j, int k) { state_.eps_min = std::min(state_.eps_min, state_.eps(i, j, k)); });
}

void VoidFraction::check_room() const {
  double eps_min;
  MPI_Allreduce(&state_.eps_min, &eps_min, 1, MPI_DOUBLE, MPI_MIN, comm_);
  if (!(eps_min > 0))
    throw std::runtime_error("the particles fill a particle cell to " + std::to_string(1 - eps_min) +
                             " of its volume and there is no room beside it, wanted: at most 1 - eps_min = " +
                             std::to_string(1 - settings_.eps_min) +
                             ": insert fewer particles, or choose larger particle cells by ratio");
}

void VoidFraction::allocate_replacement() {
  if (replaced_cells_.size() > 0 || history_.next().size() == 0) return;
  inserted_.reset(own_nodes_);
  replaced_.reset(own_nodes_);
  replaced_cells_.reset(history_.next().box());
}

const CellField<FineGrid>* VoidFraction::replacement(const Particles& p, const Selection& selection,
                                                     const Census& census, Interphase& exchange) {
  exchange.replaced = (census.new_particles > 0 || change_.changed) && !settings_.one_way;
  exchange.same_flux = change_.changed;
  if (!exchange.replaced) return nullptr;
  allocate_replacement();
  deposit_(p, selection.new_ones(), inserted_);
  const FixedPoint& scale = deposit_.scale();
  for_each(own_nodes_, [&](int i, int j, int k) {
    replaced_(i, j, k) = 0 - nodes_.share_of(scale.value(inserted_(i, j, k)), i, j, k);
  });
  hand_down(replaced_);
  prolongation_.constant(replaced_, replaced_cells_);
  if (change_.changed)
    for (std::size_t m = 0; m < replaced_cells_.size(); ++m) replaced_cells_.data()[m] += change_.eps.data()[m];
  change_.changed = false;
  return &replaced_cells_;
}

/// eps on the particle grid of the particles that the last coupling knew, where they are now.
void VoidFraction::lay_out(const Particles& p, const Selection& selection, CellField<ParticleGrid>& eps) {
  double mine = 0, largest = 0;
  std::vector<int> known;
  for (int i : selection.inside())
    if (p.state[i][kVoidFraction] != 0 && std::isfinite(p.radius[i]) && selection.window().covers(p.x[i])) {
      known.push_back(i);
      mine = std::max(mine, p.radius[i]);
    }
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  deposit_.prepare(std::max(largest, state_.largest_radius));
  allocate_replacement();
  deposit_(p, known, inserted_);
  const FixedPoint& scale = deposit_.scale();
  limit_(scale, inserted_);
  if (eps.size() == 0) eps.reset(state_.eps.box(), 1.0);
  for_each(own_nodes_,
           [&](int i, int j, int k) { eps(i, j, k) = 1 - nodes_.share_of(scale.value(inserted_(i, j, k)), i, j, k); });
  hand_down(eps);
}

void VoidFraction::rest(const Particles& p, const Selection& selection) {
  if (!settings_.one_way) lay_out(p, selection, change_.rest_eps);
}

void VoidFraction::go_on(const Particles& p, const Selection& selection) {
  state_.still = false;
  if (settings_.one_way) return;
  CellField<ParticleGrid> eps;
  lay_out(p, selection, eps);
  double mine = 0, largest = 0;
  for_each(own_nodes_,
           [&](int i, int j, int k) { mine = std::max(mine, std::abs(eps(i, j, k) - change_.rest_eps(i, j, k))); });
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  if (largest < 1e-9) return;
  CellField<FineGrid>& after = history_.next();  // free until the next coupling
  if (!change_.changed) change_.eps.reset(after.box());
  prolongation_(change_.rest_eps, replaced_cells_);
  prolongation_(eps, after);
  for (std::size_t m = 0; m < after.size(); ++m) change_.eps.data()[m] += after.data()[m] - replaced_cells_.data()[m];
  change_.changed = true;
}

}  // namespace twogrid
