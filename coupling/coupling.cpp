#include "coupling/coupling.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "cfd/parallel/reduction.h"
#include "coupling/control/between_runs.h"
#include "coupling/control/coupling_error.h"
#include "coupling/control/stopwatch.h"
#include "coupling/forces/drag.h"
#include "coupling/forces/exchange_model.h"
#include "coupling/forces/gather_fluid.h"
#include "coupling/forces/interval_end.h"
#include "coupling/forces/mean_motion.h"
#include "coupling/forces/momentum_exchange.h"
#include "coupling/forces/pressure_force.h"
#include "coupling/forces/step_forces.h"
#include "coupling/forces/undisturbed_force.h"
#include "coupling/particles/ledger.h"
#include "coupling/selection/census.h"
#include "coupling/selection/selection.h"
#include "coupling/two_grid/reader.h"
#include "coupling/void_fraction/void_fraction.h"

namespace twogrid {

namespace {

/// Interval over response time of the particles above which `hold auto` holds the flux, and below which it lets go.
constexpr double kHoldAbove = 0.05, kHoldBelow = 0.025;

/// Interval over response time above which the implicit coefficient b' lies so far below b that the drag on what the
/// fluid does below the size of a reading is completed (momentum_exchange.h).
constexpr double kComplete = 0.02;
/// The same for the time in which a particle crosses what it reads: below, b'' is b to 10 %.
constexpr double kFollow = 0.2;

/// The particle grid, its nodes' volumes those that are open to the fluid.
ParticleGrid nodes_of(MPI_Comm comm, const Fluid& fluid, const Int3& ratio, const Int3& search = {1, 1, 1}) {
  ParticleGrid nodes(fluid.grid(), ratio);
  nodes.take_open_part(comm, fluid, search);
  return nodes;
}
/// What particles read: fine cells as nodes, where that is so. An open cell is as far away as the next node's other end.
ParticleGrid read_nodes(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& nodes, Read read) {
  const Int3& r = nodes.ratio;
  return reads_fine_cells(read) ? nodes_of(comm, fluid, {1, 1, 1}, {2 * r[0], 2 * r[1], 2 * r[2]}) : nodes;
}

const DragLaw& drag_law_of(const Settings& s) {
  check(s);
  return *find_drag_law(s.drag);
}

}  // namespace

class Coupling::Impl {
 public:
  Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region);

  void start(Particles& p, double dem_dt);
  void rest(Particles& p);
  void advance(Particles& p, int steps, double dem_dt, bool check);
  void force(Particles& p, double dem_dt, bool accumulate);
  void move_region(const ParticleRegion& region);
  const OpenNodes* open_nodes() const { return nodes_.open_nodes(); }
  long long in_closed_cells(const Particles& p) const;
  void restored() { void_fraction_.restored(), report_.take(state_, fluid_.time()); }

  CouplingState state_;
  Report report_;
  Shares shares_;
  Fluid& fluid_;
  StepForces forces_;
  std::vector<std::unique_ptr<ExchangeModel>> models_;

 private:
  void go_on(Particles& p);
  void select(const Particles& p);
  void end_interval(Particles& p, double interval, double dem_dt);
  void take_census(const Particles& p, const Survey& mine);
  void deposit(const Particles& p);
  void react(Particles& p, double interval);
  FluidReport advance_fluid(const Particles& p, double interval, bool check);
  void gather_fluid(Particles& p, double interval);
  void load_groups(bool kick);
  void hold_motion(Particles& p, const GatherMaxima& all);
  ExchangeSite site(Particles& p, double interval);
  void choose_hold();
  MeanMotion& motion();
  void close_ledger(double interval);

  bool formulation_A() const { return settings_.formulation == Formulation::kA; }

  MPI_Comm comm_;
  Settings settings_;
  const DragLaw& law_;
  ParticleRegion region_;
  ParticleGrid nodes_;
  VoidFraction void_fraction_;
  Reader reader_;
  double read_length_;  // of what a particle reads (m)
  double cell_width_;   // smallest mean width of a particle cell, directions of one cell left out (m)
  Selection selection_;
  MomentumExchange exchange_;
  std::optional<UndisturbedForce> undisturbed_;  // formulation A only
  std::unique_ptr<MeanMotion> motion_;           // made when first needed
  CouplingError coupling_error_;

  // Of this coupling; lists belong to selection_.inside().
  Census census_;
  Ledger ledger_;
  std::array<double, 7> ledger_sums_;  // over ranks
  Places places_;
  std::vector<ImplicitDrag> drag_;
  std::vector<FourNumbers> flux_velocity_;  // what continuity sees (m/s)
  std::vector<Vec3> change_;                // while holding: u_read - u_seen at the interval's end (m/s)
  std::vector<double> size_ratio_;          // with several diameters
};

Coupling::Impl::Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region)
    : fluid_(fluid),
      forces_(state_.step, drag_law_of(settings), fluid.density(), fluid.viscosity()),
      comm_(comm),
      settings_(settings),
      law_(drag_law_of(settings)),
      region_(region),
      nodes_(nodes_of(comm, fluid, settings.ratio)),
      void_fraction_(state_, comm, settings, fluid, nodes_, region),
      reader_(comm, fluid, read_nodes(comm, fluid, nodes_, settings.read), region, settings.read, read_width(settings)),
      read_length_(read_width(settings) > 0 ? read_width(settings) : reader_.map().grid().smallest_width()),
      cell_width_(nodes_.smallest_width()),
      selection_(comm, nodes_, node_layout(fluid.layout(), nodes_), reader_.window(), region),
      exchange_(comm, fluid, reader_, read_length_) {
  if (formulation_A()) {
    undisturbed_.emplace(comm_, fluid_, state_.undisturbed);
    fluid_.keep_pressure_gradient();
  }
}

void Coupling::Impl::move_region(const ParticleRegion& region) {
  region_ = region;
  void_fraction_.move_region(region);
  reader_.move_region(region);
  if (motion_) motion_->move_region(region);
  selection_.move_region(region);
}

void Coupling::Impl::start(Particles& p, double dem_dt) {
  if (state_.started) {  // a further run: all state is alive, here and with the particles
    if (state_.change.resting) go_on(p);
    return;
  }
  select(p);
  Survey mine;
  begin(p, selection_.inside(), drag_, flux_velocity_, mine);
  reader_.find(p, selection_.inside(), places_);
  take_census(p, mine);
  deposit(p);
  fluid_.start(void_fraction_.history().next());
  void_fraction_.history().start();
  gather_fluid(p, settings_.every * dem_dt);
  for (int i : selection_.inside()) {
    double* s = p.state[i];
    s[kRestRadius] = p.radius[i];
    // Columns of forces hold what was applied last: nothing yet.
    for (int d = 0; d < 3; ++d) s[kDragForce + d] = -s[kPressureForce + d];
  }
  close_ledger(0);
  state_.started = true;
}

// One interval D = steps dem_dt, t^{n-1} -> t^n; particles at x(t^n).
//   end_interval  d_p = path/D;  u_ref = what the drag sees now;  b'_p = (m_p/D) (1 - exp(-b_p D/m_p))
//   deposit       V_p -> eps^n on the nodes, bounded -> on the fine cells (void_fraction.h)
//   react         V_f source_f = sum_p w_pf (b'_p u_ref - I_p/D),   V_f beta_f = sum_p w_pf b'_p (momentum_exchange.h)
//   advance_fluid t^{n-1} -> t^n
//   gather_fluid  kick K_p = b'_p (READ(mean u) - u_ref) D;  u, eps at the particles; b_p by the drag law (gather_fluid.h);
//                 several sizes or formulation A: V_p (R + D_n/eps) (pressure_force.h)
void Coupling::Impl::advance(Particles& p, int steps, double dem_dt, bool check) {
  const double interval = steps * dem_dt;
  select(p);
  end_interval(p, interval, dem_dt);
  if (check) coupling_error_.remember(p, selection_.inside(), drag_);
  deposit(p);
  react(p, interval);
  const FluidReport fluid = advance_fluid(p, interval, check);
  gather_fluid(p, interval);
  if (check) {
    report_.step_error = fluid.step_error;
    report_.coupling_error = coupling_error_.measure(comm_, p, selection_.inside());
  }
  close_ledger(interval);
  state_.fluid_steps += fluid.steps;
  report_.take(fluid, fluid_.time(), state_.fluid_steps);
}

void Coupling::Impl::select(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  selection_.find(p);
}

void Coupling::Impl::end_interval(Particles& p, double interval, double dem_dt) {
  Stopwatch watch(shares_.map);
  const std::vector<int>& inside = selection_.inside();
  IntervalEnd end{interval, state_.repeated * dem_dt, void_fraction_.history().extrapolation(interval), nullptr};
  state_.repeated = 0;
  if (state_.holding) {
    motion().update(p, state_.deposit.eps);
    change_.assign(inside.size(), {0, 0, 0});
    Vec3 pressure;
    for (std::size_t q = 0; q < inside.size(); ++q)
      if (p.step[inside[q]][kDragCoefficient] > 0) motion().change_at(p.x[inside[q]], change_[q], pressure);
    end.change = change_.data();
  }
  Survey mine;
  end_of_interval(p, inside, end, drag_, flux_velocity_, mine);
  reader_.find(p, inside, places_);
  survey_leaving(p, selection_, interval, mine);
  if (p.growing) state_.grown += growth(p, selection_);
  take_census(p, mine);
  const auto& given = settings_.fluid.flow_rate_set;
  if (given[0] || given[1] || given[2]) exchange_.set_particle_flux(p, inside, flux_velocity_);
}

/// Of all ranks; and what the ledger has of this rank's particles.
void Coupling::Impl::take_census(const Particles& p, const Survey& mine) {
  ledger_ = Ledger{};
  ledger_.action = mine.impulse;
  ledger_.magnitude += mine.impulse_size;
  ledger_.particle_volume = mine.volume;
  ledger_.inserted_volume = mine.new_volume;
  selection_.find_new(p, mine.new_particles > 0);
  census_ = twogrid::take_census(comm_, p, selection_, mine, state_.grown, nodes_.largest_volume());
  state_.grown = 0;
}

void Coupling::Impl::deposit(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  void_fraction_.deposit(p, selection_, places_, census_, ledger_);
}

void Coupling::Impl::react(Particles& p, double interval) {
  if (settings_.one_way) return;
  Stopwatch watch(shares_.map);
  const bool completed = state_.drag_number > kComplete || state_.follow > kFollow;
  for (auto& model : models_) model->give(site(p, interval));
  exchange_.react(p, selection_, places_, drag_, census_, interval, completed, ledger_);
}

FluidReport Coupling::Impl::advance_fluid(const Particles& p, double interval, bool check) {
  VoidHistory& history = void_fraction_.history();
  const CellField<FineGrid>* replaced = void_fraction_.replacement(p, selection_, census_, exchange_.exchange());
  FluidReport fluid;
  {
    Stopwatch watch(shares_.fluid);
    const VoidFractionInTime eps = history.begin(interval, replaced);
    const Interphase& exchange = exchange_.exchange();
    fluid = check ? fluid_.advance_and_check(interval, eps, exchange) : fluid_.advance(interval, eps, exchange);
  }
  if (!settings_.one_way) {
    Stopwatch watch(shares_.map);
    exchange_.count_reaction(interval, ledger_);
  }
  history.commit();
  return fluid;
}

void Coupling::Impl::gather_fluid(Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const std::vector<int>& inside = selection_.inside();
  const bool kick = state_.started && !settings_.one_way;
  const bool mean_loaded = kick && &fluid_.mean_velocity() != &fluid_.velocity();
  if (formulation_A() && state_.started)
    undisturbed_->update(fluid_, void_fraction_.history().now(), exchange_.exchange(),
                         mean_density(comm_, p, inside, fluid_.density()));
  load_groups(mean_loaded);
  const bool several_sizes = census_.several_sizes();
  const bool pressure_force = formulation_A() || (several_sizes && !settings_.one_way);
  const bool of_models = std::any_of(models_.begin(), models_.end(), [](auto& m) { return m->forces(); });
  if ((state_.step.own_force && !pressure_force) || of_models) clear_pressure_force(p, inside);
  state_.step.pressure_force = pressure_force;
  state_.step.own_force = pressure_force || of_models;
  if (several_sizes) {
    motion().average_diameters(p, inside, census_.radius, census_.terms);
    size_ratio_.resize(inside.size());
    for (std::size_t q = 0; q < inside.size(); ++q)
      size_ratio_[q] = 2 * p.radius[inside[q]] / motion().diameter(p.x[inside[q]]);
  }
  GatherMaxima all;
  correct_and_gather(
      p, inside, drag_,
      {reader_, places_, law_, forces_, fluid_.density(), fluid_.viscosity(), interval, read_length_, kick, mean_loaded,
       formulation_A(), !pressure_force, several_sizes ? size_ratio_.data() : nullptr},
      all);
  for (int d = 0; d < 3; ++d) ledger_.action[d] += all.kick[d].value();
  ledger_.magnitude += all.kick_size;
  for (int i : selection_.leaving()) Selection::set_outside(p, i);
  double minus_eps_min = -state_.deposit.eps_min;
  std::array<double, 7>& l = ledger_sums_ = ledger_.own();
  Reduction::over_ranks(comm_,
                        {&all.speed, &all.drag, &all.drag_coefficient, &all.drag_number, &all.follow, &minus_eps_min},
                        {&l[0], &l[1], &l[2], &l[3], &l[4], &l[5], &l[6]});
  state_.drag_number = all.drag_number;
  state_.follow = all.follow;
  report_.eps_min = -minus_eps_min;
  report_.travel = all.speed * interval / cell_width_;
  choose_hold();
  if (!settings_.one_way && (pressure_force || state_.holding)) hold_motion(p, all);
  for (auto& model : models_) model->take(site(p, interval));
}

ExchangeSite Coupling::Impl::site(Particles& p, double interval) {
  return {comm_,         p,     selection_.inside(), places_, reader_, fluid_, void_fraction_.history().now(), interval,
          census_.terms, state_};
}

/// What particles read: u and eps; u for the next reaction; its mean where it is another; the undisturbed flow's force.
void Coupling::Impl::load_groups(bool mean) {
  const CellField<FineGrid>& fine = void_fraction_.history().now();
  const FaceField<FineGrid>* const now = &fluid_.velocity();
  const Array3<double>* const eps =
      reads_fine_cells(settings_.read) ? static_cast<const Array3<double>*>(&fine) : &state_.deposit.eps;
  std::vector<ReadGroup> groups{{now, eps, &fine}, {now}};
  if (mean) groups.push_back({&fluid_.mean_velocity()});
  if (undisturbed_) groups.push_back({&undisturbed_->field()});
  reader_.load(groups);
}

void Coupling::Impl::choose_hold() {
  if (settings_.one_way || settings_.hold_flux == Choice::kOff)
    state_.holding = false;
  else if (settings_.hold_flux == Choice::kOn)
    state_.holding = true;
  else
    state_.holding = state_.drag_number > (state_.holding ? kHoldBelow : kHoldAbove);
}

/// The particles' mean motion at this coupling, from which the steps to come know what has changed since.
void Coupling::Impl::hold_motion(Particles& p, const GatherMaxima& all) {
  MeanMotion::Largest scale;
  scale.mass = census_.mass, scale.momentum = census_.mass * std::max(all.speed, census_.flux_velocity);
  scale.drag = all.drag, scale.drag_coefficient = all.drag_coefficient;
  scale.terms = census_.terms;
  const bool drag = state_.step.pressure_force;
  motion().couple(p, selection_.inside(), flux_velocity_, state_.deposit.eps, scale, drag);
  if (drag) add_pressure_of_drag(p, selection_.inside(), motion(), formulation_A());
}

MeanMotion& Coupling::Impl::motion() {
  if (!motion_) {
    std::array<bool, 3> free_flux = nodes_.periodic();
    for (int d = 0; d < 3; ++d) free_flux[d] = free_flux[d] && !settings_.fluid.flow_rate_set[d];
    motion_ =
        std::make_unique<MeanMotion>(state_.motion, comm_, nodes_, node_layout(fluid_.layout(), nodes_), region_,
                                     settings_.read == Read::kTrilinear ? Spread::kLinear : Spread::kCell, free_flux);
  }
  return *motion_;
}

/// interval: 0 at the beginning, where nothing can have vanished.
void Coupling::Impl::close_ledger(double interval) {
  const Ledger::Balance balance = Ledger::balance(ledger_sums_);
  double vanished =
      interval > 0 ? state_.known_volume + balance.inserted_volume + census_.grown - balance.solid_volume : 0.0;
  if (std::abs(vanished) <= 1e-10 * state_.known_volume) vanished = 0;  // round-off of the sums
  state_.inserted += balance.inserted_volume;
  state_.vanished += vanished;
  state_.all_grown += census_.grown;
  state_.known_volume = balance.solid_volume;
  report_.take(state_, census_, balance, vanished);
  if (interval > 0 && !settings_.one_way) report_.momentum_error = balance.momentum_error;
}

void Coupling::Impl::rest(Particles& p) {
  if (!state_.started || state_.change.resting) return;
  state_.change.resting = true;
  select(p);
  void_fraction_.rest(p, selection_);
  if (p.growing) state_.grown += growth(p, selection_);
  note_columns(p);
}

/// What differs from rest() has been changed by commands.
void Coupling::Impl::go_on(Particles& p) {
  state_.change.resting = false;
  state_.grown += take_up_columns(p, forces_);
  select(p);
  void_fraction_.go_on(p, selection_);
}

long long Coupling::Impl::in_closed_cells(const Particles& p) const {
  const OpenShares* const open = fluid_.open_shares();
  if (!open) return 0;
  const ParticleGrid cells(fluid_.grid(), {1, 1, 1});
  const Window window(comm_, cells, fluid_.layout(), region_, Spread::kCell, 0.0);
  Array3<double> theta(window.box());
  window.bring<double>({&open->theta()}, {&theta});
  long long mine = 0, all = 0;
  for (int i : selection_.inside()) mine += theta.data()[window.node(p.x[i])] == 0;
  MPI_Allreduce(&mine, &all, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  return all;
}

void Coupling::Impl::force(Particles& p, double dem_dt, bool accumulate) {
  Stopwatch watch(shares_.force);
  if (state_.holding) motion().update(p, state_.deposit.eps);
  forces_(p, dem_dt, accumulate, state_.holding ? &motion() : nullptr);
}

Coupling::Coupling(MPI_Comm comm, const Settings& settings, Fluid& fluid, const Vec3& sub_lo, const Vec3& sub_hi,
                   double reach)
    : impl_(std::make_unique<Impl>(comm, settings, fluid, ParticleRegion{sub_lo, sub_hi, reach})) {}

Coupling::~Coupling() = default;

void Coupling::start(Particles& p, double dem_dt) {
  impl_->start(p, dem_dt);
}
void Coupling::move_region(const Vec3& sub_lo, const Vec3& sub_hi, double reach) {
  impl_->move_region(ParticleRegion{sub_lo, sub_hi, reach});
}
void Coupling::advance(Particles& p, int steps, double dem_dt, bool check) {
  impl_->advance(p, steps, dem_dt, check);
}
void Coupling::rest(Particles& p) {
  impl_->rest(p);
}
bool Coupling::resting() const {
  return impl_->state_.change.resting;
}
void Coupling::force(Particles& p, double dem_dt, bool accumulate) {
  impl_->force(p, dem_dt, accumulate);
}
void Coupling::finish_step(Particles& p) {
  impl_->forces_.finish_step(p);
}
void Coupling::repeat_force() {
  ++impl_->state_.repeated;
}
void Coupling::add_model(std::unique_ptr<ExchangeModel> model) {
  impl_->models_.push_back(std::move(model));
}
void Coupling::set_gravity(const std::vector<Weight>& weights) {
  impl_->forces_.set_gravity(weights);
}
void Coupling::restored() {
  impl_->restored();
}
Report& Coupling::report_to_restore() {
  return impl_->report_;
}
CouplingState& Coupling::state() {
  return impl_->state_;
}
const OpenNodes* Coupling::open_nodes() const {
  return impl_->open_nodes();
}
long long Coupling::in_closed_cells(const Particles& p) const {
  return impl_->in_closed_cells(p);
}
const Report& Coupling::report() const {
  return impl_->report_;
}
const Shares& Coupling::shares() const {
  return impl_->shares_;
}
Fluid& Coupling::fluid() {
  return impl_->fluid_;
}

}  // namespace twogrid
