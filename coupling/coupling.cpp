#include "coupling/coupling.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <stdexcept>
#include <vector>

#include "cfd/parallel/reduction.h"
#include "coupling/forces/drag.h"
#include "coupling/forces/gather_fluid.h"
#include "coupling/forces/interval_end.h"
#include "coupling/forces/mean_motion.h"
#include "coupling/forces/step_forces.h"
#include "coupling/forces/undisturbed_force.h"
#include "coupling/particles/ledger.h"
#include "coupling/two_grid/reader.h"
#include "coupling/void_fraction/solid_limit.h"
#include "coupling/void_fraction/void_history.h"
#include "coupling/void_fraction/volume_deposit.h"

namespace twogrid {

namespace {

/// Interval over response time of the particles above which `hold auto` holds the flux, and below which it lets go.
constexpr double kHoldAbove = 0.05, kHoldBelow = 0.025;

/// Interval over response time above which the implicit coefficient b' lies so far below b that the drag on what the
/// fluid does below the size of a reading is completed (complete_drag()).
constexpr double kComplete = 0.02;
/// The same for the time in which a particle crosses what it reads: below, b'' is b to 10 %.
constexpr double kFollow = 0.2;

/// Adds the CPU time of its life to a share.
class Stopwatch {
 public:
  explicit Stopwatch(double& share) : share_(share), start_(std::clock()) {}
  ~Stopwatch() { share_ += double(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  double& share_;
  std::clock_t start_;
};

/// Largest values over all particles of all ranks that the fixed-point sums and the choice to hold the flux need.
struct Extremes {
  double radius = 0, minus_radius = -1e300, mass = 0, reaction = 0, response = 0, flux_velocity = 0, follow = 0;
};

void check(const Settings& s) {
  auto refuse = [](const std::string& sentence) { throw std::invalid_argument(sentence); };
  auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", x);
    return std::string(text);
  };
  if (!find_drag_law(s.drag))
    refuse("drag: there is no law called '" + s.drag + "', wanted one of: " + drag_law_names());
  if (!(s.eps_min > 0 && s.eps_min < 1)) refuse("eps_min must lie between 0 and 1, found " + number(s.eps_min));
  if (s.read == Read::kKernel && !(s.kernel_width > 0))
    refuse("read kernel needs a width above 0 (m), found " + number(s.kernel_width));
  if ((s.read == Read::kCube || s.deposit == Deposit::kCube) && !(s.cube_edge > 0))
    refuse("cube needs an edge above 0 (m), found " + number(s.cube_edge));
}

const Settings& checked(const Settings& s) {
  check(s);
  return s;
}

double read_width(const Settings& s) {
  return s.read == Read::kKernel ? s.kernel_width : s.read == Read::kCube ? s.cube_edge : 0.0;
}

/// Smallest mean width of a cell, directions of one cell left out (m).
double narrowest(const ParticleGrid& grid) {
  double width = 1e300;
  for (const Axis& a : grid.axis)
    if (a.n() > 1) width = std::min(width, a.length() / a.n());
  return width;
}

bool within(const double x[3], const Vec3& lo, const Vec3& hi) {
  return x[0] >= lo[0] && x[1] >= lo[1] && x[2] >= lo[2] && x[0] <= hi[0] && x[1] <= hi[1] && x[2] <= hi[2];
}

Box grown_unless_empty(const Box& b, int g) {
  return b.empty() ? b : b.grown(g);
}

}  // namespace

class Coupling::Impl {
 public:
  Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region);

  void start(Particles& p, double dem_dt);
  void rest(Particles& p);
  bool resting() const { return resting_; }
  void advance(Particles& p, int steps, double dem_dt, bool check);
  void force(Particles& p, double dem_dt, bool accumulate);
  void move_region(const ParticleRegion& region);
  void repeat_force() { ++repeated_; }

  Report report_;
  Shares shares_;
  Fluid& fluid_;
  StepForces forces_;

 private:
  void find_particles(const Particles& p);
  void set_outside(const Particles& p, int i);
  void end_interval(Particles& p, double interval, double dem_dt);
  void reduce(const Particles& p, const Survey& mine);
  long long find_bad(const Particles& p, double& not_finite, double& uncovered) const;
  void deposit(const Particles& p);
  void check_room() const;
  void go_on(Particles& p);
  void note_growth(const Particles& p);
  void lay_out(const Particles& p, CellField<ParticleGrid>& eps);
  void allocate_replacement();
  const CellField<FineGrid>* replacement(const Particles& p);
  void react(const Particles& p, double interval);
  void complete_drag(const Particles& p, double interval);
  double deviation_response(const Particles& p, int i) const;
  void check_reaction(double interval);
  void gather_fluid(Particles& p, double interval);
  void choose_pressure_force(Particles& p, bool sizes_differ);
  void add_pressure_of_drag(Particles& p);
  void choose_hold(double drag_number);
  void close_ledger(double interval);
  void remember_forces(const Particles& p);
  void compare_forces(const Particles& p);
  MeanMotion& motion();

  void find_inside();
  bool formulation_A() const { return settings_.formulation == Formulation::kA; }

  MPI_Comm comm_;
  Settings settings_;
  const DragLaw& law_;
  ParticleRegion region_;
  Vec3 inside_lo_, inside_hi_;  // between these a particle counts as inside, a little beyond the sides too (m)
  Vec3 surely_lo_, surely_hi_;  // and is where a particle of this rank may be
  ParticleGrid nodes_;
  double read_length_ = 0;  // of what a particle reads (m)
  double cell_width_ = 0;   // smallest mean width of a particle cell, directions of one cell left out (m)
  VolumeDeposit volume_deposit_;
  SolidLimit limit_;
  Prolongation prolongation_;
  Reader reader_;
  std::unique_ptr<MeanMotion> motion_;  // made when first needed

  // State: what one interval leaves to the next, apart from the particles' own columns.
  VoidHistory history_;
  UndisturbedForce undisturbed_;  // formulation A only
  double known_volume_ = 0;       // of the particles at the last coupling (m3)
  bool started_ = false, holding_ = false;
  bool pressure_force_ = false;  // particles feel V_p D/eps as a force of its own
  bool resting_ = false;         // between runs
  bool any_changed_ = false;     // by commands between runs, since the last coupling
  double grown_ = 0;             // volume that this rank's particles have gained since the last coupling (m3)
  bool covered_ = true;          // all particles of this rank are where they may be

  // Fields of this coupling.
  Array3<long long> solid_, inserted_;
  CellField<ParticleGrid> eps_node_, replaced_;
  CellField<ParticleGrid> rest_eps_;  // at the last run's end
  CellField<FineGrid> replaced_cells_;
  CellField<FineGrid> changed_cells_;  // what commands between runs have added to eps; only if any_changed_
  Interphase exchange_;
  NodeSpread source_, beta_;                 // its rows
  NodeSpread deviation_, deviation_beta_;    // complete_drag(): then the source is held as a field
  std::array<std::vector<double>, 3> rows_;  // scratch: made rows of faces

  // Particles of this coupling: indices, and what belongs to them.
  std::vector<int> inside_, leaving_, new_;
  std::vector<int> others_;                 // scratch of find_particles()
  std::vector<ImplicitDrag> drag_;          // of inside_
  std::vector<FourNumbers> flux_velocity_;  // of inside_: what continuity sees (m/s)
  Places places_;                           // of inside_
  std::vector<Vec3> change_;                // of inside_, while holding: u_read - u_seen at the interval's end (m/s)
  std::vector<double> size_ratio_;          // of inside_, with several diameters
  std::vector<FourNumbers> deviations_;
  std::vector<Vec3> last_force_;  // of inside_, at the end of the interval; only in a coupling that is checked
  Extremes extremes_;
  long long new_count_ = 0;
  double all_grown_ = 0;  // of all ranks, in this interval (m3)
  double terms_ = 1;
  int repeated_ = 0;   // steps since the last coupling whose force was that of the step before
  bool kept_ = false;  // nothing moved at the last coupling: its void fraction may be that of this one too
  long long kept_particles_ = 0;
  decltype(Ledger::deposited_volume) kept_volume_{};
  Ledger ledger_;
  std::array<double, 10> ledger_sums_;  // over ranks
  double eps_min_ = 1;                  // of own nodes
};

Coupling::Impl::Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region)
    : fluid_(fluid),
      forces_(*find_drag_law(checked(settings).drag), fluid.density(), fluid.viscosity()),
      comm_(comm),
      settings_(settings),
      law_(*find_drag_law(settings.drag)),
      region_(region),
      nodes_(fluid.grid(), settings.ratio),
      volume_deposit_(comm, nodes_, node_layout(fluid.layout(), nodes_), region, settings.deposit, settings.cube_edge),
      limit_(comm, nodes_, node_layout(fluid.layout(), nodes_), settings.bound, settings.eps_min),
      prolongation_(comm, fluid.grid(), fluid.layout(), nodes_, settings.prolong, settings.eps_min),
      reader_(comm, fluid, reads_fine_cells(settings.read) ? ParticleGrid(fluid.grid(), {1, 1, 1}) : nodes_, region,
              settings.read, read_width(settings)) {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  const Box own_nodes = node_layout(fluid.layout(), nodes_).cells(rank);
  history_ = VoidHistory(fluid.void_fraction().box(), settings_.interpolate);
  solid_.reset(own_nodes);
  eps_node_.reset(grown_unless_empty(own_nodes, 1), 1.0);
  if (formulation_A()) {
    undisturbed_ = UndisturbedForce(comm_, fluid_);
    fluid_.keep_pressure_gradient();
  }
  read_length_ = read_width(settings_);
  if (read_length_ == 0) read_length_ = narrowest(reader_.map().grid());
  cell_width_ = narrowest(nodes_);
  find_inside();
}

/// A particle a little beyond the box is still there, until it is exchanged. Where the box goes on beyond the fluid's
/// domain, such a particle has no place in it.
void Coupling::Impl::find_inside() {
  double reaches[6], box[6];  // upwards
  for (int d = 0; d < 3; ++d) reaches[2 * d] = -region_.lo[d], reaches[2 * d + 1] = region_.hi[d];
  MPI_Allreduce(reaches, box, 6, MPI_DOUBLE, MPI_MAX, comm_);
  for (int d = 0; d < 3; ++d) {
    const Axis& a = nodes_.axis[d];
    const double same = 1e-9 * a.length();
    inside_lo_[d] = a.periodic() ? -HUGE_VAL : a.lo() - (a.lo() + box[2 * d] < same ? region_.reach : 0.0);
    inside_hi_[d] = a.periodic() ? HUGE_VAL : a.hi() + (box[2 * d + 1] - a.hi() < same ? region_.reach : 0.0);
    surely_lo_[d] = std::max(inside_lo_[d], reader_.window().span(d).x_lo);
    surely_hi_[d] = std::min(inside_hi_[d], reader_.window().span(d).x_hi);
  }
}

void Coupling::Impl::move_region(const ParticleRegion& region) {
  region_ = region;
  volume_deposit_.move_region(region);
  reader_.move_region(region);
  if (motion_) motion_->move_region(region);
  find_inside();
}

void Coupling::Impl::start(Particles& p, double dem_dt) {
  if (started_) {  // a further run: all state is alive, here and with the particles
    if (resting_) go_on(p);
    return;
  }
  find_particles(p);
  new_.clear();
  new_count_ = 0;
  Survey mine;
  begin(p, inside_, drag_, flux_velocity_, mine);
  reader_.find(p, inside_, places_);
  reduce(p, mine);
  deposit(p);
  fluid_.start(history_.next());
  history_.start();
  gather_fluid(p, settings_.every * dem_dt);
  for (int i : inside_) p.state[i][kRestRadius] = p.radius[i];
  // Columns of forces hold what was applied last: nothing yet.
  for (int i : inside_)
    for (int d = 0; d < 3; ++d) p.state[i][kDragForce + d] = -p.state[i][kPressureForce + d];
  close_ledger(0);
  started_ = true;
}

// One interval D = steps dem_dt, t^{n-1} -> t^n; particles at x(t^n). Momentum of particle p in the interval: impulse
// I_p (received by the forces of the DEM steps) and kick K_p.
//   end_interval  d_p = path/D;  u_ref = what the drag sees now;  b'_p = (m_p/D) (1 - exp(-b_p D/m_p))
//   deposit   V_p -> eps^n on the nodes, bounded -> on the fine cells
//   react     V_f source_f = sum_p w_pf (b'_p u_ref - I_p/D),   V_f beta_f = sum_p w_pf b'_p
//   advance   the fluid
//   take      K_p = b'_p (READ(mean u) - u_ref) D, so that
//             sum_p (I_p + K_p) + sum_f V_f (source_f - beta_f u_f) D = 0;
//             u, eps at the particles; b_p by the drag law; formulation A: V_p (R + D_n/eps)
void Coupling::Impl::advance(Particles& p, int steps, double dem_dt, bool check) {
  const double interval = steps * dem_dt;
  find_particles(p);
  end_interval(p, interval, dem_dt);
  if (check) remember_forces(p);
  deposit(p);
  const CellField<FineGrid>* replaced = replacement(p);
  if (!settings_.one_way) {
    react(p, interval);
    if (report_.max_drag_number > kComplete || extremes_.follow > kFollow)
      complete_drag(p, interval);
    else
      for (auto& field : exchange_.source) field = {};
  }
  FluidReport fluid;
  {
    Stopwatch watch(shares_.fluid);
    const VoidFractionInTime eps = history_.begin(interval, replaced);
    fluid = check ? fluid_.advance_and_check(interval, eps, exchange_) : fluid_.advance(interval, eps, exchange_);
  }
  if (!settings_.one_way) check_reaction(interval);
  history_.commit();
  gather_fluid(p, interval);
  if (check) {
    report_.step_error = fluid.step_error;
    compare_forces(p);
  }
  close_ledger(interval);
  report_.fluid_time = fluid_.time();
  report_.fluid_dt = fluid.dt;
  report_.cfl = fluid.cfl;
  report_.pressure_drop = fluid.pressure_drop;
  report_.divergence_error = fluid.divergence_error;
  report_.pressure_iterations = fluid.pressure_iterations;
  report_.fluid_steps += fluid.steps;
}

namespace {

/// Particles that lie where they surely may go to `inside`, the others that take part to `others`, both in order.
TWOGRID_VECTORISED void sort_out(const Particles& p, const Vec3& surely_lo, const Vec3& surely_hi,
                                 std::vector<int>& inside, std::vector<int>& others) {
  const Four lo{surely_lo[0], surely_lo[1], surely_lo[2], -HUGE_VAL};
  const Four hi{surely_hi[0], surely_hi[1], surely_hi[2], HUGE_VAL};
  inside.resize(p.n);
  others.clear();
  int* const to = inside.data();
  int n = 0;
  for (int i = 0; i < p.n; ++i) {
    if (!p.takes_part(i)) continue;
    Four x;
    three_at(p.x[i], i + 1 == p.n, x);
    const FourIntegers within = (x >= lo) & (x <= hi);
    to[n] = i;
    if ((within[0] & within[1] & within[2]) != 0)
      ++n;
    else
      others.push_back(i);
  }
  inside.resize(n);
}

}  // namespace

void Coupling::Impl::find_particles(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  sort_out(p, surely_lo_, surely_hi_, inside_, others_);
  leaving_.clear();
  covered_ = true;
  const std::size_t sure = inside_.size();
  for (int i : others_)
    if (within(p.x[i], inside_lo_, inside_hi_) || !std::isfinite(p.x[i][0] + p.x[i][1] + p.x[i][2])) {
      inside_.push_back(i);  // what is not finite too: reduce() speaks of it
      covered_ &= reader_.window().covers(p.x[i]);
    } else if (p.step[i][kDragCoefficient] > 0) {
      leaving_.push_back(i);
    } else {
      set_outside(p, i);
    }
  if (inside_.size() > sure) std::inplace_merge(inside_.begin(), inside_.begin() + sure, inside_.end());
}

/// No fluid, and known: should it come in, its path began here, and it pushes fluid aside as any particle that moves.
void Coupling::Impl::set_outside(const Particles& p, int i) {
  double* s = p.state[i];
  std::fill(s, s + kParticleColumns, 0.0);
  std::fill(p.step[i], p.step[i] + kStepColumns, 0.0);
  s[kVoidFraction] = s[kKnown] = 1;
  for (int d = 0; d < 3; ++d) s[kPathVelocity + d] = p.v[i][d], s[kPosition + d] = p.x[i][d];
}

void Coupling::Impl::end_interval(Particles& p, double interval, double dem_dt) {
  Stopwatch watch(shares_.map);
  IntervalEnd end{interval, repeated_ * dem_dt, history_.extrapolation(interval), nullptr};
  repeated_ = 0;
  if (holding_) {
    motion().update(p);
    change_.assign(inside_.size(), {0, 0, 0});
    Vec3 pressure;
    for (std::size_t q = 0; q < inside_.size(); ++q)
      if (p.step[inside_[q]][kDragCoefficient] > 0) motion().change_at(p.x[inside_[q]], change_[q], pressure);
    end.change = change_.data();
  }
  Survey mine;
  end_of_interval(p, inside_, end, drag_, flux_velocity_, mine);
  reader_.find(p, inside_, places_);
  for (int i : leaving_)
    for (int d = 0; d < 3; ++d) {
      const double impulse = p.step[i][kImpulse + d];
      mine.impulse[d] += impulse;
      mine.impulse_size += std::abs(impulse);
      mine.reaction = std::max(mine.reaction, std::abs(impulse) / interval);
      mine.finite = mine.finite && std::isfinite(impulse + p.x[i][d] + p.v[i][d]);
    }
  if (p.growing) note_growth(p);
  reduce(p, mine);
  const auto& given = settings_.fluid.flow_rate_set;
  if (given[0] || given[1] || given[2]) {  // the flow rate is that of fluid and particles together
    Vec3 sum{0, 0, 0};
    for (std::size_t q = 0; q < inside_.size(); ++q)
      for (int d = 0; d < 3; ++d) sum[d] += sphere_volume(p.radius[inside_[q]]) * flux_velocity_[q].at[d];
    MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, comm_);
    const auto& axis = fluid_.grid().axis;
    for (int d = 0; d < 3; ++d)
      exchange_.particle_flux[d] = sum[d] / (axis[0].length() * axis[1].length() * axis[2].length());
  }
}

/// Looks for particles that can't be served; tag of one of them, or -1.
long long Coupling::Impl::find_bad(const Particles& p, double& not_finite, double& uncovered) const {
  long long bad_tag = -1;
  for (const std::vector<int>* list : {&inside_, &leaving_})
    for (int i : *list) {
      double sum = 0;
      for (int d = 0; d < 3; ++d) sum += p.x[i][d] + p.v[i][d] + p.step[i][kImpulse + d];
      const bool finite = std::isfinite(sum);
      if (finite && (list == &leaving_ || reader_.window().covers(p.x[i]))) continue;
      ++(finite ? uncovered : not_finite);
      bad_tag = std::max(bad_tag, p.tag ? (long long)p.tag[i] : (long long)i);
    }
  return bad_tag;
}

/// Extremes over all ranks; what the ledger has of this rank's particles.
void Coupling::Impl::reduce(const Particles& p, const Survey& mine) {
  ledger_ = Ledger{};
  ledger_.action = mine.impulse;
  ledger_.magnitude += mine.impulse_size;
  ledger_.particle_volume = mine.volume;
  ledger_.inserted_volume = mine.new_volume;
  double count[5] = {double(inside_.size()), double(mine.new_particles), 0, 0, double(leaving_.size())};
  long long bad_tag = -1;
  if (!mine.finite || !covered_) bad_tag = find_bad(p, count[3], count[2]);
  new_.clear();
  if (mine.new_particles > 0)
    for (int i : inside_)
      if (p.state[i][kVoidFraction] == 0) new_.push_back(i);
  extremes_ = {mine.radius,   mine.minus_radius,  mine.mass,       mine.reaction,
               mine.response, mine.flux_velocity, extremes_.follow};
  double tag = double(bad_tag);
  all_grown_ = grown_;
  grown_ = 0;
  Reduction::over_ranks(comm_,
                        {&extremes_.radius, &extremes_.minus_radius, &extremes_.mass, &extremes_.reaction,
                         &extremes_.response, &extremes_.flux_velocity, &tag},
                        {&count[0], &count[1], &count[2], &count[3], &count[4], &all_grown_});
  if (count[3] > 0)
    throw std::runtime_error(std::to_string((long long)count[3]) +
                             " particles have a position, velocity or impulse that is " +
                             "not finite, one of them tag " + std::to_string((long long)tag) +
                             ". It became so since the last coupling: by a contact (a timestep too long for its "
                             "stiffness and damping, or two "
                             "spheres in one place), or by the drag; reduce timestep or every");
  if (count[2] > 0)
    throw std::runtime_error(std::to_string((long long)count[2]) + " particles lie further than " +
                             std::to_string(region_.reach) + " m outside their rank's box, one of them tag " +
                             std::to_string((long long)tag) +
                             ": let the neighbour lists be rebuilt more often, or reduce timestep");
  report_.particles = (long long)count[0];
  new_count_ = (long long)count[1];
  // Most particles a node's sum can hold: all of them, or what sixteen times its volume holds; and those that leave.
  const double smallest = count[0] > 0 ? sphere_volume(-extremes_.minus_radius) : 1.0;
  terms_ = std::max(1.0, std::min(count[0], 16 * (nodes_.largest_volume() / smallest + 1)) + count[4]);
}

void Coupling::Impl::deposit(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  CellField<FineGrid>& fine = history_.next();
  if (settings_.one_way) {  // the fluid doesn't know of the particles
    fine.fill(1.0);
    ledger_.deposited_volume = ledger_.particle_volume;
    return;
  }
  // What follows from positions alone stays, where nothing moves, came or went.
  const bool keep = p.still && kept_ && new_count_ == 0 && report_.particles == kept_particles_;
  kept_ = p.still && started_;
  kept_particles_ = report_.particles;
  if (keep) {
    fine = history_.now();
    ledger_.deposited_volume = kept_volume_;
    return;
  }
  volume_deposit_.prepare(extremes_.radius);
  const bool same_places = (settings_.deposit == Deposit::kTrilinear && settings_.read == Read::kTrilinear) ||
                           (settings_.deposit == Deposit::kCentroid && settings_.read == Read::kCell);
  volume_deposit_(p, inside_, solid_, same_places ? &places_ : nullptr);
  const FixedPoint& scale = volume_deposit_.scale();
  const SolidLimit::Result limited = limit_(scale, solid_);
  report_.volume_moved = limited.displaced;
  report_.volume_unplaced = limited.unplaced;
  eps_min_ = 1;
  for_each(solid_.box(), [&](int i, int j, int k) {
    const double eps = 1 - scale.value(solid_(i, j, k)) / nodes_.volume(i, j, k);
    eps_node_(i, j, k) = eps;
    eps_min_ = std::min(eps_min_, eps);
  });
  if (limited.unplaced > 0) check_room();  // else no node is above the bound
  prolongation_(eps_node_, fine);
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  const FineGrid& grid = fluid_.grid();
  for_each(fluid_.layout().cells(rank),
           [&](int i, int j, int k) { ledger_.deposited_volume += (1 - fine(i, j, k)) * grid.volume(i, j, k); });
  kept_volume_ = ledger_.deposited_volume;
}

void Coupling::Impl::check_room() const {
  double eps_min;
  MPI_Allreduce(&eps_min_, &eps_min, 1, MPI_DOUBLE, MPI_MIN, comm_);
  if (!(eps_min > 0))
    throw std::runtime_error("the particles fill a particle cell to " + std::to_string(1 - eps_min) +
                             " of its volume and there is no room beside it, wanted: at most 1 - eps_min = " +
                             std::to_string(1 - settings_.eps_min) +
                             ": insert fewer particles, or choose larger particle cells by ratio");
}

void Coupling::Impl::note_growth(const Particles& p) {
  for (const std::vector<int>* list : {&inside_, &leaving_})
    for (int i : *list) {
      double* s = p.state[i];
      if (s[kVoidFraction] != 0 && p.radius[i] != s[kRestRadius])
        grown_ += sphere_volume(p.radius[i]) - sphere_volume(s[kRestRadius]);
      s[kRestRadius] = p.radius[i];
    }
}

/// Void fraction on the particle grid of the particles that the last coupling knew, where they are now.
void Coupling::Impl::lay_out(const Particles& p, CellField<ParticleGrid>& eps) {
  find_particles(p);
  double mine = 0, largest = 0;
  std::vector<int> known;
  for (int i : inside_)
    if (p.state[i][kVoidFraction] != 0 && std::isfinite(p.radius[i]) && reader_.window().covers(p.x[i])) {
      known.push_back(i);
      mine = std::max(mine, p.radius[i]);
    }
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  volume_deposit_.prepare(std::max(largest, extremes_.radius));
  allocate_replacement();
  volume_deposit_(p, known, inserted_);
  const FixedPoint& scale = volume_deposit_.scale();
  limit_(scale, inserted_);
  if (eps.size() == 0) eps.reset(eps_node_.box(), 1.0);
  for_each(inserted_.box(),
           [&](int i, int j, int k) { eps(i, j, k) = 1 - scale.value(inserted_(i, j, k)) / nodes_.volume(i, j, k); });
}

void Coupling::Impl::rest(Particles& p) {
  if (!started_ || resting_) return;
  resting_ = true;
  if (!settings_.one_way) lay_out(p, rest_eps_);
  if (p.growing) note_growth(p);
  for (int i = 0; i < p.n; ++i) {
    double* s = p.state[i];
    if (!p.takes_part(i) || s[kKnown] == 0) continue;
    for (int d = 0; d < 3; ++d) s[kPosition + d] -= p.x[i][d];
    s[kRestMass] = p.mass[i], s[kRestRadius] = p.radius[i];
  }
}

/// What differs from rest() has been changed by commands. Where they have deleted particles, made them smaller or moved
/// them away, fluid takes their place at the next coupling, and the other way round.
void Coupling::Impl::go_on(Particles& p) {
  resting_ = kept_ = false;
  for (int i = 0; i < p.n; ++i) {
    double* s = p.state[i];
    if (!p.takes_part(i) || s[kKnown] == 0) continue;
    for (int d = 0; d < 3; ++d) s[kPosition + d] += p.x[i][d];
    if (p.mass[i] != s[kRestMass]) forces_.renew_decay(p, i);
    if (p.radius[i] != s[kRestRadius] && s[kVoidFraction] != 0)
      grown_ += sphere_volume(p.radius[i]) - sphere_volume(s[kRestRadius]);
    s[kRestRadius] = p.radius[i];
  }
  if (settings_.one_way) return;
  CellField<ParticleGrid> eps;
  lay_out(p, eps);
  double mine = 0, largest = 0;
  for_each(inserted_.box(),
           [&](int i, int j, int k) { mine = std::max(mine, std::abs(eps(i, j, k) - rest_eps_(i, j, k))); });
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  if (largest < 1e-9) return;
  CellField<FineGrid>& after = history_.next();  // free until the next coupling
  if (!any_changed_) changed_cells_.reset(after.box());
  prolongation_(rest_eps_, replaced_cells_);
  prolongation_(eps, after);
  for (std::size_t m = 0; m < after.size(); ++m)
    changed_cells_.data()[m] += after.data()[m] - replaced_cells_.data()[m];
  any_changed_ = true;
}

void Coupling::Impl::allocate_replacement() {
  if (replaced_cells_.size() > 0 || history_.next().size() == 0) return;
  inserted_.reset(solid_.box());
  replaced_.reset(solid_.box());
  replaced_cells_.reset(history_.next().box());
}

/// Change of eps by particles that came since the last coupling, and by commands between runs; null: none.
const CellField<FineGrid>* Coupling::Impl::replacement(const Particles& p) {
  exchange_.replaced = (new_count_ > 0 || any_changed_) && !settings_.one_way;
  exchange_.same_flux = any_changed_;
  if (!exchange_.replaced) return nullptr;
  allocate_replacement();
  volume_deposit_(p, new_, inserted_);
  const FixedPoint& scale = volume_deposit_.scale();
  for_each(inserted_.box(), [&](int i, int j, int k) {
    replaced_(i, j, k) = 0 - scale.value(inserted_(i, j, k)) / nodes_.volume(i, j, k);
  });
  prolongation_.constant(replaced_, replaced_cells_);
  if (any_changed_)
    for (std::size_t m = 0; m < replaced_cells_.size(); ++m) replaced_cells_.data()[m] += changed_cells_.data()[m];
  any_changed_ = false;
  return &replaced_cells_;
}

namespace {

TWOGRID_VECTORISED void add_reactions(Reader& reader, const Particles& p, const std::vector<int>& who,
                                      const Places& places, const std::vector<ImplicitDrag>& drag,
                                      const Four& per_unit) {
  const WindowShape shape = reader.shape();
  FourWholeNumbers* const sum = reader.sum();
  reader.at_places(p, who, places, [&](std::size_t q, const auto& place) {
    scatter(place, shape, (drag[q].given * per_unit + kWhole) - kWhole, sum);
  });
}

}  // namespace

void Coupling::Impl::react(const Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const std::array<FixedPoint, 2> scale{FixedPoint(extremes_.reaction, terms_), FixedPoint(extremes_.response, terms_)};
  const double force = scale[0].per_unit(), coefficient = scale[1].per_unit();
  reader_.clear_reaction();
  add_reactions(reader_, p, inside_, places_, drag_, Four{force, force, force, coefficient});
  Stencil w;
  for (int i : leaving_) {
    Four q{0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) q[d] = scale[0].whole(-p.step[i][kImpulse + d] / interval);
    reader_.window().weights(p.x[i], w);
    reader_.react(w, q);
  }
  Vec3 held_back;
  reader_.collect(scale, source_, beta_, held_back);
  exchange_.source_rows = &source_;
  exchange_.beta_rows = &beta_;
  for (int d = 0; d < 3; ++d) ledger_.wall[d] += held_back[d] * interval;
}

/// What a particle reads is a mean over faces, R_p u. In react() face f feels, of particle p, w_pf times
///   -I_p/D + b'_p (u_ref - u_f) = -I_p/D + b'_p (u_ref - R_p u) + b'_p (R_p u - u_f):
/// the last is drag on the fluid's own deviation from what the particle reads, with a coefficient that depends on the
/// interval. The coefficient wanted is b''_p = (m/T)(1 - exp(-b T/m)), T the time in which the particle crosses what it
/// reads: heavy particles resist the deviation with b in full, light ones would follow it, did they see it. The rest,
/// (b'' - b') (R_p u - u_f), is added here with u of the interval's begin. Its sum over the faces is zero: no particle
/// receives it. Being explicit it is kept below half of the implicit part.
double Coupling::Impl::deviation_response(const Particles& p, int i) const {
  const double* s = p.state[i];
  const double b = s[kResponse];
  if (p.held(i)) return b;
  double v2 = 0, slip2 = 0;
  for (int d = 0; d < 3; ++d) {
    const double slip = s[kFluidVelocity + d] - p.v[i][d];
    v2 += p.v[i][d] * p.v[i][d];
    slip2 += slip * slip;
  }
  return b * mean_decay(b * read_length_ / (p.mass[i] * (std::sqrt(v2) + std::sqrt(slip2)) + 1e-300));
}

void Coupling::Impl::complete_drag(const Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const FaceField<FineGrid>& u = fluid_.velocity();
  reader_.load({{&u}});
  double largest[2] = {0, 0}, all[2];
  deviations_.resize(inside_.size());
  reader_.at_places(p, inside_, places_, [&](std::size_t q, const auto& place) {
    const double implicit = drag_[q].given[3];
    const double b = std::clamp(deviation_response(p, inside_[q]) - implicit, -implicit, 0.5 * implicit);
    Four read;
    reader_.at<1>(place, &read);
    double* const deviation = deviations_[q].at;
    four_at(deviation) = b * read;
    deviation[3] = b;
    for (int d = 0; d < 3; ++d) largest[0] = std::max(largest[0], std::abs(deviation[d]));
    largest[1] = std::max(largest[1], std::abs(b));
  });
  MPI_Allreduce(largest, all, 2, MPI_DOUBLE, MPI_MAX, comm_);
  const std::array<FixedPoint, 2> scale{FixedPoint(all[0], terms_), FixedPoint(all[1], terms_)};
  reader_.clear_reaction();
  reader_.at_places(p, inside_, places_, [&](std::size_t q, const auto& place) {
    Four whole;
    for (int c = 0; c < 4; ++c) whole[c] = scale[c < 3 ? 0 : 1].whole(deviations_[q].at[c]);
    reader_.react(place, whole);
  });
  Vec3 held_back;
  reader_.collect(scale, deviation_, deviation_beta_, held_back);
  for (int d = 0; d < 3; ++d) {
    ledger_.wall[d] += held_back[d] * interval;
    const Box& b = reader_.map().faces(d);
    const int n = b.size(0);
    FaceComponent<FineGrid>& source = exchange_.source[d];
    source.reset(b);
    for (auto& r : rows_) r.resize(std::max(r.size(), std::size_t(n)));
    double *by = rows_[0].data(), *beta = rows_[1].data();
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        double* s = &source.data()[source.index(b.lo[0], j, k)];
        const double* v = &u[d].data()[u[d].index(b.lo[0], j, k)];
        source_.row(d, b.lo[0], j, k, n, s);
        deviation_.row(d, b.lo[0], j, k, n, by);
        deviation_beta_.row(d, b.lo[0], j, k, n, beta);
        for (int i = 0; i < n; ++i) s[i] += by[i] - beta[i] * v[i];
      }
  }
}

/// What the fluid has received from the particles in the interval, for the ledger.
void Coupling::Impl::check_reaction(double interval) {
  Stopwatch watch(shares_.map);
  const FaceField<FineGrid>& mean = fluid_.mean_velocity();
  for (int d = 0; d < 3; ++d) {
    const Box& b = reader_.map().faces(d);
    const int n = b.size(0);
    for (auto& r : rows_) r.resize(std::max(r.size(), std::size_t(n)));
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        const double *source = exchange_.source_row(d, b.lo[0], j, k, n, rows_[0].data()),
                     *beta = exchange_.beta_row(d, b.lo[0], j, k, n, rows_[1].data()),
                     *u = &mean[d].data()[mean[d].index(b.lo[0], j, k)];
        double* const force = rows_[2].data();
        for (int i = 0; i < n; ++i) force[i] = source[i] - beta[i] * u[i];
        ledger_.reaction[d] += reader_.map().integral(d, j, k, force) * interval;
      }
  }
}

/// The kick, and what particles read for the next interval.
void Coupling::Impl::gather_fluid(Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const bool A = formulation_A(), kick = started_ && !settings_.one_way;
  const CellField<FineGrid>& fine = history_.now();
  const FaceField<FineGrid>*const now = &fluid_.velocity(), *const mean = &fluid_.mean_velocity();
  const Array3<double>* const eps =
      reads_fine_cells(settings_.read) ? static_cast<const Array3<double>*>(&fine) : &eps_node_;
  std::vector<ReadGroup> groups{{now, eps, &fine}, {now}};
  if (kick && mean != now) groups.push_back({mean});
  if (A) {
    if (started_) {
      double sums[2] = {0, 0}, all[2];
      for (int i : inside_) sums[0] += p.mass[i], sums[1] += sphere_volume(p.radius[i]);
      MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm_);
      undisturbed_.update(fluid_, fine, exchange_, all[1] > 0 ? all[0] / all[1] : fluid_.density());
    }
    groups.push_back({&undisturbed_.field()});
  }
  reader_.load(groups);
  const double smallest = -extremes_.minus_radius;
  const bool polydisperse = report_.particles > 0 && extremes_.radius > smallest * (1 + 1e-9);
  choose_pressure_force(p, polydisperse);
  if (polydisperse) {
    motion().average_diameters(p, inside_, extremes_.radius, terms_);
    size_ratio_.resize(inside_.size());
    for (std::size_t q = 0; q < inside_.size(); ++q)
      size_ratio_[q] = 2 * p.radius[inside_[q]] / motion().diameter(p.x[inside_[q]]);
  }
  GatherMaxima mine;
  correct_and_gather(p, inside_, drag_,
                     {reader_, places_, law_, forces_, fluid_.density(), fluid_.viscosity(), interval, read_length_,
                      kick, kick && mean != now, A, !pressure_force_, polydisperse ? size_ratio_.data() : nullptr},
                     mine);
  for (int d = 0; d < 3; ++d) ledger_.action[d] += mine.kick[d].value();
  ledger_.magnitude += mine.kick_size;
  for (int i : leaving_) set_outside(p, i);
  double minus_eps_min = -eps_min_;
  std::array<double, 10>& l = ledger_sums_ = ledger_.own();
  Reduction::over_ranks(
      comm_, {&mine.speed, &mine.drag, &mine.drag_coefficient, &mine.drag_number, &mine.follow, &minus_eps_min},
      {&l[0], &l[1], &l[2], &l[3], &l[4], &l[5], &l[6], &l[7], &l[8], &l[9]});
  extremes_.follow = mine.follow;
  report_.eps_min = -minus_eps_min;
  report_.travel = mine.speed * interval / cell_width_;
  choose_hold(mine.drag_number);
  if (settings_.one_way || !(pressure_force_ || holding_)) return;
  MeanMotion::Largest scale;
  scale.mass = extremes_.mass, scale.momentum = extremes_.mass * std::max(mine.speed, extremes_.flux_velocity);
  scale.drag = mine.drag, scale.drag_coefficient = mine.drag_coefficient;
  scale.terms = terms_;
  motion().couple(p, inside_, flux_velocity_, eps_node_, scale, pressure_force_);
  if (pressure_force_) add_pressure_of_drag(p);
}

/// Formulation B leaves -V_p grad p out and divides the drag by eps instead: the gradient that balances the drag,
/// D/eps, gives every particle the same share of its own drag, if all are of one size. Where sizes differ it doesn't,
/// and the force is b_p (u - v) + V_p D/eps. (So is it in formulation A, with the residual V_p R.)
void Coupling::Impl::choose_pressure_force(Particles& p, bool sizes_differ) {
  const bool wanted = formulation_A() || (sizes_differ && !settings_.one_way);
  if (pressure_force_ && !wanted)
    for (int i : inside_)
      for (int d = 0; d < 3; ++d) p.state[i][kPressureForce + d] = 0;
  pressure_force_ = wanted;
  forces_.set_pressure_force(wanted);
  report_.pressure_force = wanted;
}

/// The part of the pressure gradient's force that balances the drag, V_p D/eps.
void Coupling::Impl::add_pressure_of_drag(Particles& p) {
  const bool residual = formulation_A();  // has been read
  double beta;
  Vec3 drag;
  for (int i : inside_) {
    double* s = p.state[i];
    motion().drag_at(p.x[i], beta, drag);
    const double volume = sphere_volume(p.radius[i]);
    s[kResponse] = p.step[i][kDragCoefficient] + volume * beta;
    for (int d = 0; d < 3; ++d) s[kPressureForce + d] = (residual ? s[kPressureForce + d] : 0.0) + volume * drag[d];
  }
}

void Coupling::Impl::choose_hold(double drag_number) {
  report_.max_drag_number = drag_number;
  if (settings_.one_way || settings_.hold_flux == Choice::kOff)
    holding_ = false;
  else if (settings_.hold_flux == Choice::kOn)
    holding_ = true;
  else
    holding_ = drag_number > (holding_ ? kHoldBelow : kHoldAbove);
  report_.holding_flux = holding_;
}

void Coupling::Impl::remember_forces(const Particles& p) {
  last_force_.resize(inside_.size());
  for (std::size_t q = 0; q < inside_.size(); ++q) {
    const int i = inside_[q];
    const double* s = p.state[i];
    // What holding the flux has changed is in drag_.seen.
    for (int d = 0; d < 3; ++d) {
      const double seen = p.step[i][kStepVelocity + d] + (drag_[q].seen[d] - s[kFluidVelocity + d]);
      last_force_[q][d] = p.step[i][kDragCoefficient] * (seen - p.v[i][d]) + s[kPressureForce + d];
    }
  }
}

/// What the particles felt between couplings was held; here it jumps to its new value.
void Coupling::Impl::compare_forces(const Particles& p) {
  double sum[2] = {0, 0};
  for (std::size_t q = 0; q < inside_.size(); ++q) {
    const int i = inside_[q];
    const double* s = p.state[i];
    for (int d = 0; d < 3; ++d) {
      const double force =
          p.step[i][kDragCoefficient] * (p.step[i][kStepVelocity + d] - p.v[i][d]) + s[kPressureForce + d];
      const double jump = force - last_force_[q][d];
      sum[0] += 0.25 * jump * jump;
      sum[1] += force * force;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, comm_);
  report_.coupling_error = sum[1] > 0 ? std::sqrt(sum[0] / sum[1]) : 0.0;
}

MeanMotion& Coupling::Impl::motion() {
  if (!motion_) {
    std::array<bool, 3> free_flux = nodes_.periodic();
    for (int d = 0; d < 3; ++d) free_flux[d] = free_flux[d] && !settings_.fluid.flow_rate_set[d];
    motion_ =
        std::make_unique<MeanMotion>(comm_, nodes_, node_layout(fluid_.layout(), nodes_), region_,
                                     settings_.read == Read::kTrilinear ? Spread::kLinear : Spread::kCell, free_flux);
  }
  return *motion_;
}

void Coupling::Impl::close_ledger(double interval) {
  const Ledger::Balance balance = Ledger::balance(ledger_sums_);
  report_.solid_volume = balance.solid_volume;
  report_.solid_volume_error = balance.volume_error;
  if (interval > 0 && !settings_.one_way) report_.momentum_error = balance.momentum_error;
  report_.volume_inserted = balance.inserted_volume;
  report_.volume_vanished =
      interval > 0 ? known_volume_ + balance.inserted_volume + all_grown_ - balance.solid_volume : 0.0;
  if (std::abs(report_.volume_vanished) <= 1e-10 * known_volume_) report_.volume_vanished = 0;  // round-off of the sums
  report_.inserted_total += report_.volume_inserted;
  report_.vanished_total += report_.volume_vanished;
  report_.grown_total += all_grown_;
  known_volume_ = balance.solid_volume;
}

void Coupling::Impl::force(Particles& p, double dem_dt, bool accumulate) {
  Stopwatch watch(shares_.force);
  if (holding_) motion().update(p);
  forces_(p, dem_dt, accumulate, holding_ ? &motion() : nullptr);
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
  return impl_->resting();
}
void Coupling::force(Particles& p, double dem_dt, bool accumulate) {
  impl_->force(p, dem_dt, accumulate);
}
void Coupling::finish_step(Particles& p) {
  impl_->forces_.finish_step(p);
}
void Coupling::repeat_force() {
  impl_->repeat_force();
}
void Coupling::set_gravity(const std::vector<Weight>& weights) {
  impl_->forces_.set_gravity(weights);
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
