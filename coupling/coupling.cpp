#include "coupling.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "../cfd/compiled.h"
#include "deposit.h"
#include "drag.h"
#include "eps_bound.h"
#include "ledger.h"
#include "mean_motion.h"
#include "plain_forces.h"
#include "read.h"
#include "residual.h"
#include "void_history.h"

namespace twogrid {

namespace {

/// Interval over response time of the particles above which `hold auto` holds the flux, and below which it lets go.
constexpr double kHoldAbove = 0.05, kHoldBelow = 0.025;

/// Interval over response time above which b' is so far below b that the fluid's own drag has to be completed.
constexpr double kComplete = 0.02;
/// The same for the time in which a particle crosses what it reads: below, b'' is b to 10 %.
constexpr double kFollow = 0.2;

/// Step over response time above which a step counts as stiff: below, the error of a constant b is under 1e-3.
constexpr double kStiff = 0.02;
constexpr double kPi = 3.14159265358979323846;
constexpr int kStiffRounds = 4;

/// (1 - e^-k)/k, the mean of e^-s over [0, k]: for k up to kStiff to 1e-14, and for any.
double mean_decay_series(double k) {
  return 1 - k * (1.0 / 2 - k * (1.0 / 6 - k * (1.0 / 24 - k * (1.0 / 120 - k / 720))));
}
double mean_decay(double k) {
  return k <= kStiff ? mean_decay_series(k) : -std::expm1(-k) / k;
}

/// Adds the CPU time of its life to a share.
class Stopwatch {
 public:
  explicit Stopwatch(double& share) : share_(share), start_(std::clock()) {}
  ~Stopwatch() { share_ += double(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  double& share_;
  std::clock_t start_;
};

/// Largest values over all particles that the fixed-point sums and the choice to hold the flux need.
struct Extremes {
  double radius = 0, minus_radius = -1e300, mass = 0, momentum = 0, reaction = 0, response = 0, drag_coefficient = 0,
         drag = 0, drag_number = 0, follow = 0, speed2 = 0, flux2 = 0;
  long long bad_tag = -1;
};

/// Particles on their way through the drag law.
struct DragBatch {
  static constexpr int kSize = 8 * kDragBatch;
  int n = 0, i[kSize];
  double eps[kSize], slip[kSize], Re[kSize], y[kSize], F[kSize];

  bool full() const { return n == kSize; }
  void add(int particle, double its_eps, double its_slip, double its_Re, double its_y) {
    i[n] = particle, eps[n] = its_eps, slip[n] = its_slip, Re[n] = its_Re, y[n] = its_y;
    ++n;
  }
  void find_F(const DragLaw& law) {
    int groups = n;
    for (; groups % kDragBatch; ++groups) eps[groups] = 1, Re[groups] = 0, y[groups] = 1;
    law.F_of(groups, eps, Re, y, F);
  }
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

Box grown_unless_empty(const Box& b, int g) {
  return b.empty() ? b : b.grown(g);
}

}  // namespace

class Coupling::Impl {
 public:
  Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region);

  void start(Particles& p, double dem_dt);
  void advance(Particles& p, int steps, double dem_dt, bool check);
  void force(Particles& p, double dem_dt, bool accumulate);
  void finish_step(Particles& p);
  void repeat_force() { ++repeated_; }

  Report report_;
  Shares shares_;
  Fluid& fluid_;
  Vec3 gravity_{0, 0, 0};

 private:
  void find_particles(const Particles& p);
  void find_nodes(const Particles& p);
  void set_outside(const Particles& p, int i);
  void wrap_up(Particles& p, double interval, double dem_dt);
  void reduce(const Particles& p, Extremes& mine);
  void deposit(const Particles& p);
  void find_deleted(const Particles& p);
  void allocate_replacement();
  const CellField<FineGrid>* replacement(const Particles& p);
  void react(const Particles& p, double interval);
  void complete_drag(const Particles& p, double interval);
  double deviation_response(const Particles& p, int i) const;
  template <class F>
  void at_places(const Particles& p, F f) const;
  void kick(Particles& p, double interval);
  void read(Particles& p, double interval);
  template <bool kA>
  void read_particles(Particles& p, double interval, bool polydisperse, Extremes& mine);
  void rebuild_pressure_force(Particles& p);
  void choose_hold(double drag_number);
  void close_ledger(double interval);
  void remember_forces(const Particles& p);
  void compare_forces(const Particles& p);
  MeanMotion& motion();

  void find_inside();
  template <bool kHolding, bool kHeld>
  void forces(Particles& p, double dem_dt, bool accumulate);
  void plain_forces(Particles& p, double dem_dt);
  void find_decay(Particles& p, double dem_dt);
  double plain_decay(double b, double per_mass) const;
  template <bool kHolding, bool kHeld>
  void force_on(Particles& p, int i, double dem_dt, bool accumulate);
  bool formulation_A() const { return compiled::kFormulationA && settings_.formulation == Formulation::kA; }
  bool inside(const double x[3]) const;
  double law_at(const Particles& p, int i, const Vec3& slip) const;
  void stiff_forces(const Particles& p, int i, double k_per_b, double dem_dt, const Vec3& steady, const Vec3& slip,
                    bool ends_a_step, Vec3& first, Vec3& second) const;

  MPI_Comm comm_;
  Settings settings_;
  const DragLaw& law_;
  ParticleRegion region_;
  Vec3 inside_lo_, inside_hi_;  // between these a particle counts as inside, a little beyond the sides too (m)
  ParticleGrid nodes_;
  double read_length_ = 0;  // of what a particle reads (m)
  double cell_width_ = 0;   // smallest mean width of a particle cell, directions of one cell left out (m)
  VolumeDeposit volume_deposit_;
  SolidLimit limit_;
  Inject inject_;
  Reader reader_;
  std::unique_ptr<MeanMotion> motion_;  // made when first needed

  // State: what one interval leaves to the next, apart from the particles' own columns.
  VoidHistory history_;
  Residual residual_;        // formulation A only
  double known_volume_ = 0;  // of the particles at the last coupling (m3)
  bool started_ = false, holding_ = false;
  bool any_deleted_ = false;
  double decay_dt_ = 0;  // DEM step of the particles' kDecay (s); 0: none yet

  // Fields of this coupling.
  Array3<long long> solid_, inserted_;
  CellField<ParticleGrid> eps_node_, replaced_;
  CellField<ParticleGrid> deleted_;  // fraction of solids deleted before this run; only if any_deleted_
  CellField<FineGrid> replaced_cells_;
  Interphase exchange_;
  NodeSpread source_, beta_;                 // its rows
  NodeSpread deviation_, deviation_beta_;    // complete_drag(): then the source is held as a field
  std::array<std::vector<double>, 3> rows_;  // scratch: made rows of faces

  // Particles of this coupling: indices, and what belongs to them.
  std::vector<int> inside_, leaving_, new_;
  std::vector<int> left_;  // of plain_forces()
  std::vector<Vec3> flux_velocity_;
  std::vector<double> response_;       // b' of inside_ (kg/s)
  std::vector<Vec3> seen_, reaction_;  // of inside_: u_seen (m/s), b' u_seen - I/D (N)
  std::vector<std::ptrdiff_t> node_;   // of inside_: what it reads, where that is one node
  std::vector<Corners> corners_;       // or where that lies between nodes
  std::vector<std::array<double, 4>> deviations_;
  std::vector<Vec3> last_force_;  // of inside_, at the end of the interval; only in a coupling that is checked
  Extremes extremes_;
  long long new_count_ = 0;
  double terms_ = 1;
  std::vector<int> stiff_;  // particles of this rank's last step, for finish_step()
  int repeated_ = 0;        // steps since the last coupling whose force was that of the step before
  bool kept_ = false;       // nothing moved at the last coupling: its void fraction may be that of this one too
  long long kept_particles_ = 0;
  decltype(Ledger::deposited_volume) kept_volume_{};
  Ledger ledger_;
};

Coupling::Impl::Impl(MPI_Comm comm, const Settings& settings, Fluid& fluid, const ParticleRegion& region)
    : fluid_(fluid),
      comm_(comm),
      settings_(checked(settings)),
      law_(*find_drag_law(settings.drag)),
      region_(region),
      nodes_(fluid.grid(), settings.ratio),
      volume_deposit_(comm, nodes_, node_layout(fluid.layout(), nodes_), region, settings.deposit, settings.cube_edge),
      limit_(comm, nodes_, node_layout(fluid.layout(), nodes_), settings.bound, settings.eps_min),
      inject_(comm, fluid.grid(), fluid.layout(), nodes_, settings.prolong, settings.eps_min),
      reader_(comm, fluid, reads_fine_cells(settings.read) ? ParticleGrid(fluid.grid(), {1, 1, 1}) : nodes_, region,
              settings.read, read_width(settings)) {
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  const Box own_nodes = node_layout(fluid.layout(), nodes_).cells(rank);
  history_ = VoidHistory(fluid.void_fraction().box(), settings_.interpolate);
  solid_.reset(own_nodes);
  eps_node_.reset(grown_unless_empty(own_nodes, 1), 1.0);
  if (formulation_A()) {
    residual_ = Residual(comm_, fluid_);
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
  }
}

void Coupling::Impl::start(Particles& p, double dem_dt) {
  if (started_) {  // a further run: all state is alive, here and with the particles
    find_deleted(p);
    return;
  }
  find_particles(p);
  new_.clear();
  new_count_ = 0;
  flux_velocity_.clear();
  for (int i : inside_) {
    double* s = p.state[i];
    std::fill(s, s + kParticleColumns, 0.0);
    for (int d = 0; d < 3; ++d) s[kPathVelocity + d] = p.v[i][d], s[kPosition + d] = p.x[i][d];
    flux_velocity_.push_back({p.v[i][0], p.v[i][1], p.v[i][2]});
  }
  find_nodes(p);
  Extremes mine;
  reduce(p, mine);
  ledger_ = Ledger{};
  deposit(p);
  fluid_.start(history_.next());
  history_.start();
  read(p, settings_.every * dem_dt);
  // Columns of forces hold what was applied last: nothing yet.
  for (int i : inside_)
    for (int d = 0; d < 3; ++d) p.state[i][kDragForce + d] = -p.state[i][kPressureForce + d];
  close_ledger(0);
  started_ = true;
}

// One interval D = steps dem_dt, t^{n-1} -> t^n; particles at x(t^n). Momentum of particle p in the interval: impulse
// I_p (received by the forces of the DEM steps) and kick K_p.
//   wrap_up   d_p = path/D;  u_ref = what the drag sees now;  b'_p = (m_p/D) (1 - exp(-b_p D/m_p))
//   deposit   V_p -> eps^n on the nodes, bounded -> on the fine cells
//   react     V_f source_f = sum_p w_pf (b'_p u_ref - I_p/D),   V_f beta_f = sum_p w_pf b'_p
//   advance   the fluid
//   kick      K_p = b'_p (READ(mean u) - u_ref) D, so that  sum_p (I_p + K_p) + sum_f V_f (source_f - beta_f u_f) D = 0
//   read      u, eps at the particles; b_p by the drag law; formulation A: V_p (R + D_n/eps)
void Coupling::Impl::advance(Particles& p, int steps, double dem_dt, bool check) {
  const double interval = steps * dem_dt;
  ledger_ = Ledger{};
  find_particles(p);
  wrap_up(p, interval, dem_dt);
  check = compiled::kAccuracy && check;
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
  if (!settings_.one_way) kick(p, interval);
  history_.commit();
  read(p, interval);
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

bool Coupling::Impl::inside(const double x[3]) const {
  return x[0] >= inside_lo_[0] && x[1] >= inside_lo_[1] && x[2] >= inside_lo_[2] && x[0] <= inside_hi_[0] &&
         x[1] <= inside_hi_[1] && x[2] <= inside_hi_[2];
}

void Coupling::Impl::find_particles(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  inside_.clear();
  leaving_.clear();
  new_.clear();
  for (int i = 0; i < p.n; ++i) {
    if (!p.takes_part(i)) continue;
    if (inside(p.x[i])) {
      inside_.push_back(i);
      if (p.state[i][kVoidFraction] == 0) new_.push_back(i);
    } else if (p.state[i][kDragCoefficient] > 0) {
      leaving_.push_back(i);
    } else {
      set_outside(p, i);
    }
  }
}

void Coupling::Impl::find_nodes(const Particles& p) {
  const std::size_t n = inside_.size();
  if (reader_.single()) {
    node_.resize(n);
    for (std::size_t q = 0; q < n; ++q) node_[q] = reader_.node(p.x[inside_[q]]);
  } else if (reader_.linear()) {
    corners_.resize(n);
    for (std::size_t q = 0; q < n; ++q) corners_[q] = reader_.corners(p.x[inside_[q]]);
  }
}

/// No fluid, and known: should it come in, its path began here, and it pushes fluid aside as any particle that moves.
void Coupling::Impl::set_outside(const Particles& p, int i) {
  double* s = p.state[i];
  std::fill(s, s + kParticleColumns, 0.0);
  s[kVoidFraction] = 1;
  for (int d = 0; d < 3; ++d) s[kPathVelocity + d] = p.v[i][d], s[kPosition + d] = p.x[i][d];
}

void Coupling::Impl::wrap_up(Particles& p, double interval, double dem_dt) {
  Stopwatch watch(shares_.map);
  if (compiled::kHold && holding_) motion().update(p);
  const double r = history_.extrapolation(interval);
  flux_velocity_.resize(inside_.size());
  response_.resize(inside_.size());
  seen_.resize(inside_.size());
  reaction_.resize(inside_.size());
  find_nodes(p);
  const double inverse_interval = 1 / interval;
  Extremes mine;
  const bool held = compiled::kHeld && p.some_held();
  const double repeated = repeated_ * dem_dt;
  repeated_ = 0;
  auto note_impulse = [&](const double* s) {
    for (int d = 0; d < 3; ++d) {
      ledger_.action[d] += s[kImpulse + d];
      ledger_.magnitude += std::abs(s[kImpulse + d]);
    }
  };
  const auto particles = [&](auto holding) {
    constexpr bool kHolding = decltype(holding)::value;
    for (std::size_t q = 0; q < inside_.size(); ++q) {
      const int i = inside_[q];
      double* s = p.state[i];
      if (repeated > 0)
        for (int d = 0; d < 3; ++d) s[kImpulse + d] += repeated * (s[kDragForce + d] + s[kPressureForce + d]);
      const bool is_new = s[kVoidFraction] == 0;
      Vec3 c{0, 0, 0}, pressure;
      if (kHolding && s[kDragCoefficient] > 0) motion().change_at(p.x[i], c, pressure);
      const double b =
          held && p.held(i) ? s[kResponse] : s[kResponse] * mean_decay(s[kResponse] * interval / p.mass[i]);
      response_[q] = b;
      mine.response = std::max(mine.response, b);
      for (int d = 0; d < 3; ++d) {
        const double mean = is_new ? p.v[i][d] : p.path(i, d) * inverse_interval;
        flux_velocity_[q][d] = is_new ? mean : mean + r * (mean - s[kPathVelocity + d]);
        s[kPathVelocity + d] = mean;
        s[kPosition + d] = p.x[i][d];
        s[kSeenVelocity + d] = seen_[q][d] = kHolding ? s[kFluidVelocity + d] - c[d] : s[kFluidVelocity + d];
        reaction_[q][d] = b * seen_[q][d] - s[kImpulse + d] * inverse_interval;
        mine.reaction = std::max(mine.reaction, std::abs(reaction_[q][d]));
      }
      note_impulse(s);
    }
  };
  if (compiled::kHold && holding_)
    particles(std::true_type{});
  else
    particles(std::false_type{});
  for (int i : leaving_) {
    note_impulse(p.state[i]);
    for (int d = 0; d < 3; ++d) mine.reaction = std::max(mine.reaction, std::abs(p.state[i][kImpulse + d]) / interval);
  }
  reduce(p, mine);
  const auto& given = settings_.fluid.flow_rate_set;
  if (given[0] || given[1] || given[2]) {  // the flow rate is that of fluid and particles together
    Vec3 sum{0, 0, 0};
    for (std::size_t q = 0; q < inside_.size(); ++q)
      for (int d = 0; d < 3; ++d) sum[d] += sphere_volume(p.radius[inside_[q]]) * flux_velocity_[q][d];
    MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, comm_);
    const auto& axis = fluid_.grid().axis;
    for (int d = 0; d < 3; ++d)
      exchange_.particle_flux[d] = sum[d] / (axis[0].length() * axis[1].length() * axis[2].length());
  }
}

void Coupling::Impl::reduce(const Particles& p, Extremes& mine) {
  long long count[5] = {(long long)inside_.size(), (long long)new_.size(), 0, 0, (long long)leaving_.size()},
            all_counts[5];
  for (int i : inside_) {
    mine.radius = std::max(mine.radius, p.radius[i]);
    mine.minus_radius = std::max(mine.minus_radius, -p.radius[i]);
    mine.mass = std::max(mine.mass, p.mass[i]);
    const bool finite = std::isfinite(p.x[i][0] + p.x[i][1] + p.x[i][2] + p.v[i][0] + p.v[i][1] + p.v[i][2]) &&
                        std::isfinite(p.state[i][kImpulse] + p.state[i][kImpulse + 1] + p.state[i][kImpulse + 2]);
    const bool covered = reader_.window().covers(p.x[i]);
    if (finite && covered) continue;
    ++count[finite ? 2 : 3];
    mine.bad_tag = std::max(mine.bad_tag, p.tag ? (long long)p.tag[i] : (long long)i);
  }
  const double largest[6] = {mine.radius,   mine.minus_radius, mine.mass,
                             mine.reaction, mine.response,     double(mine.bad_tag)};
  double all[6];
  MPI_Allreduce(largest, all, 6, MPI_DOUBLE, MPI_MAX, comm_);
  MPI_Allreduce(count, all_counts, 5, MPI_LONG_LONG, MPI_SUM, comm_);
  if (all_counts[3] > 0)
    throw std::runtime_error(
        std::to_string(all_counts[3]) + " particles have a position, velocity or impulse that is " +
        "not finite, one of them tag " + std::to_string((long long)all[5]) + ": reduce timestep or every");
  if (all_counts[2] > 0)
    throw std::runtime_error(std::to_string(all_counts[2]) + " particles lie further than " +
                             std::to_string(region_.reach) + " m outside their rank's box, one of them tag " +
                             std::to_string((long long)all[5]) +
                             ": let the neighbour lists be rebuilt more often, or reduce timestep");
  extremes_.radius = all[0], extremes_.minus_radius = all[1], extremes_.mass = all[2];
  extremes_.reaction = all[3], extremes_.response = all[4];
  report_.particles = all_counts[0];
  new_count_ = all_counts[1];
  // Most particles a node's sum can hold: all of them, or what sixteen times its volume holds; and those that leave.
  const double smallest = all_counts[0] > 0 ? sphere_volume(-extremes_.minus_radius) : 1.0;
  terms_ = std::max(
      1.0, std::min(double(all_counts[0]), 16 * (nodes_.largest_volume() / smallest + 1)) + double(all_counts[4]));
}

void Coupling::Impl::deposit(const Particles& p) {
  Stopwatch watch(shares_.deposit);
  for (int i : inside_) ledger_.particle_volume += sphere_volume(p.radius[i]);
  for (int i : new_) ledger_.inserted_volume += sphere_volume(p.radius[i]);
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
  volume_deposit_(p, inside_, solid_);
  const FixedPoint& scale = volume_deposit_.scale();
  const SolidLimit::Result limited = limit_(scale, solid_);
  report_.volume_moved = limited.displaced;
  report_.volume_unplaced = limited.unplaced;
  double eps_min = 1;
  for_each(solid_.box(), [&](int i, int j, int k) {
    const double eps = 1 - scale.value(solid_(i, j, k)) / nodes_.volume(i, j, k);
    eps_node_(i, j, k) = eps;
    eps_min = std::min(eps_min, eps);
  });
  MPI_Allreduce(&eps_min, &report_.eps_min, 1, MPI_DOUBLE, MPI_MIN, comm_);
  if (!(report_.eps_min > 0))
    throw std::runtime_error("the particles fill a particle cell to " + std::to_string(1 - report_.eps_min) +
                             " of its volume and there is no room beside it, wanted: at most 1 - eps_min = " +
                             std::to_string(1 - settings_.eps_min) +
                             ": insert fewer particles, or choose larger particle cells by ratio");
  inject_(eps_node_, fine);
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  const FineGrid& grid = fluid_.grid();
  for_each(fluid_.layout().cells(rank),
           [&](int i, int j, int k) { ledger_.deposited_volume += (1 - fine(i, j, k)) * grid.volume(i, j, k); });
  kept_volume_ = ledger_.deposited_volume;
}

/// Commands between two runs may have deleted particles. Fluid takes their place at the next coupling: what
/// the solids on the nodes have lost since the last one. (With it go the few steps of motion since then.)
void Coupling::Impl::find_deleted(const Particles& p) {
  if (settings_.one_way) return;
  find_particles(p);
  std::vector<int> old;
  double volume = 0;
  for (const std::vector<int>* list : {&inside_, &leaving_})
    for (int i : *list)
      if (p.state[i][kVoidFraction] > 0) old.push_back(i), volume += sphere_volume(p.radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &volume, 1, MPI_DOUBLE, MPI_SUM, comm_);
  if (known_volume_ - volume <= 1e-10 * known_volume_) return;
  allocate_replacement();
  volume_deposit_(p, old, inserted_);
  const FixedPoint& scale = volume_deposit_.scale();
  limit_(scale, inserted_);
  for_each(inserted_.box(), [&](int i, int j, int k) {
    deleted_(i, j, k) = scale.value(solid_(i, j, k) - inserted_(i, j, k)) / nodes_.volume(i, j, k);
  });
  any_deleted_ = true;
}

void Coupling::Impl::allocate_replacement() {
  if (inserted_.size() > 0) return;
  inserted_.reset(solid_.box());
  deleted_.reset(solid_.box());
  replaced_.reset(solid_.box());
  replaced_cells_.reset(history_.next().box());
}

/// Change of eps by particles that came or went since the last coupling; null: none did.
const CellField<FineGrid>* Coupling::Impl::replacement(const Particles& p) {
  exchange_.replaced = (new_count_ > 0 || any_deleted_) && !settings_.one_way;
  if (!exchange_.replaced) return nullptr;
  allocate_replacement();
  volume_deposit_(p, new_, inserted_);
  const FixedPoint& scale = volume_deposit_.scale();
  for_each(inserted_.box(), [&](int i, int j, int k) {
    const double gone = any_deleted_ ? deleted_(i, j, k) : 0.0;
    replaced_(i, j, k) = gone - scale.value(inserted_(i, j, k)) / nodes_.volume(i, j, k);
  });
  any_deleted_ = false;
  inject_.constant(replaced_, replaced_cells_);
  return &replaced_cells_;
}

/// f(q, i, place) for every particle i = inside_[q], with what it reads: weights; or one node, or the corners about it,
/// as find_nodes() has found them.
template <class F>
void Coupling::Impl::at_places(const Particles& p, F f) const {
  if (reader_.single()) {
    for (std::size_t q = 0; q < inside_.size(); ++q) f(q, inside_[q], node_[q]);
    return;
  }
  if (reader_.linear()) {
    for (std::size_t q = 0; q < inside_.size(); ++q) f(q, inside_[q], corners_[q]);
    return;
  }
  Stencil w;
  for (std::size_t q = 0; q < inside_.size(); ++q) {
    reader_.weights(p.x[inside_[q]], w);
    f(q, inside_[q], w);
  }
}

void Coupling::Impl::react(const Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const std::array<FixedPoint, 2> scale{FixedPoint(extremes_.reaction, terms_), FixedPoint(extremes_.response, terms_)};
  reader_.clear_reaction();
  at_places(p, [&](std::size_t q, int, const auto& place) {
    const Vec3& r = reaction_[q];
    reader_.react(place, {scale[0].quantise(r[0]), scale[0].quantise(r[1]), scale[0].quantise(r[2]),
                          scale[1].quantise(response_[q])});
  });
  Stencil w;
  for (int i : leaving_) {
    const double* s = p.state[i];
    std::array<long long, Reader::kReactions> q{};
    for (int d = 0; d < 3; ++d) q[d] = scale[0].quantise(-s[kImpulse + d] / interval);
    reader_.weights(p.x[i], w);
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
/// the last is drag on the fluid's own deviation from what the particle reads, with a coefficient that hangs on the
/// interval. Meant is b''_p = (m/T)(1 - exp(-b T/m)), T the time in which the particle crosses what it reads: heavy
/// particles resist the deviation with b in full, light ones would follow it, did they see it. The rest,
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
  reader_.load(u);
  double largest[2] = {0, 0}, all[2];
  std::vector<std::array<double, 4>>& deviation = deviations_;
  deviation.resize(inside_.size());
  at_places(p, [&](std::size_t q, int i, const auto& place) {
    const double b = std::clamp(deviation_response(p, i) - response_[q], -response_[q], 0.5 * response_[q]);
    double read[3];
    reader_.at<3>(place, read);
    for (int d = 0; d < 3; ++d) {
      deviation[q][d] = b * read[d];
      largest[0] = std::max(largest[0], std::abs(deviation[q][d]));
    }
    deviation[q][3] = b;
    largest[1] = std::max(largest[1], std::abs(b));
  });
  MPI_Allreduce(largest, all, 2, MPI_DOUBLE, MPI_MAX, comm_);
  const std::array<FixedPoint, 2> scale{FixedPoint(all[0], terms_), FixedPoint(all[1], terms_)};
  reader_.clear_reaction();
  at_places(p, [&](std::size_t q, int, const auto& place) {
    std::array<long long, Reader::kReactions> units;
    for (int c = 0; c < 4; ++c) units[c] = scale[c < 3 ? 0 : 1].quantise(deviation[q][c]);
    reader_.react(place, units);
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

void Coupling::Impl::kick(Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const FaceField<FineGrid>& mean = fluid_.mean_velocity();
  reader_.load(mean);
  double size = 0;
  std::array<Sum, 3> given;
  const bool held = compiled::kHeld && p.some_held();
  at_places(p, [&](std::size_t q, int i, const auto& place) {
    double u[3];
    reader_.at<3>(place, u);
    const double scale = response_[q] * interval, inverse_mass = held && p.held(i) ? 0 : 1 / p.mass[i];
    for (int d = 0; d < 3; ++d) {
      const double k = scale * (u[d] - seen_[q][d]);
      p.v[i][d] += k * inverse_mass;
      given[d] += k;
      size += std::abs(k);
    }
  });
  for (int d = 0; d < 3; ++d) ledger_.action[d] += given[d].value();
  ledger_.magnitude += size;
  for (int d = 0; d < 3; ++d) {
    const Box& b = reader_.map().faces(d);
    const int n = b.size(0);
    for (auto& r : rows_) r.resize(std::max(r.size(), std::size_t(n)));
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        const double *source = exchange_.source_row(d, b.lo[0], j, k, n, rows_[0].data()),
                     *beta = exchange_.beta_row(d, b.lo[0], j, k, n, rows_[1].data()),
                     *u = &mean[d].data()[mean[d].index(b.lo[0], j, k)];
        double row = 0;  // plain within a row, compensated over rows
        for (int i = 0; i < n; ++i)
          row += (source[i] - beta[i] * u[i]) * reader_.map().face_volume(d, b.lo[0] + i, j, k);
        ledger_.reaction[d] += row * interval;
      }
  }
}

void Coupling::Impl::read(Particles& p, double interval) {
  Stopwatch watch(shares_.map);
  const bool A = formulation_A();
  const CellField<FineGrid>& fine = history_.now();
  const Array3<double>& eps_field =
      reads_fine_cells(settings_.read) ? static_cast<const Array3<double>&>(fine) : eps_node_;
  if (A) {
    if (started_) {
      double sums[2] = {0, 0}, all[2];
      for (int i : inside_) sums[0] += p.mass[i], sums[1] += sphere_volume(p.radius[i]);
      MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm_);
      residual_.update(fluid_, fine, exchange_, all[1] > 0 ? all[0] / all[1] : fluid_.density());
    }
    reader_.load(fluid_.velocity(), eps_field, residual_.field());
  } else {
    reader_.load(fluid_.velocity(), eps_field);
  }
  const double smallest = -extremes_.minus_radius;
  const bool polydisperse =
      compiled::kPolydisperse && report_.particles > 0 && extremes_.radius > smallest * (1 + 1e-9);
  if (polydisperse) motion().average_diameters(p, inside_, extremes_.radius, terms_);

  Extremes mine;
  if (A)
    read_particles<compiled::kFormulationA>(p, interval, polydisperse, mine);
  else
    read_particles<false>(p, interval, polydisperse, mine);
  for (int i : leaving_) set_outside(p, i);
  double largest[6] = {mine.momentum, mine.drag, mine.drag_coefficient, mine.drag_number, mine.follow, mine.speed2},
         all[6];
  MPI_Allreduce(largest, all, 6, MPI_DOUBLE, MPI_MAX, comm_);
  extremes_.follow = all[4];
  report_.travel = std::sqrt(all[5]) * interval / cell_width_;
  choose_hold(all[3]);
  if (settings_.one_way || !(A || holding_)) return;
  MeanMotion::Largest scale;
  scale.mass = extremes_.mass, scale.momentum = all[0], scale.drag = all[1], scale.drag_coefficient = all[2];
  scale.terms = terms_;
  motion().couple(p, inside_, flux_velocity_, eps_node_, scale, A);
  if (A) rebuild_pressure_force(p);
}

/// u, eps and in formulation A the residual at the particles, and b_p by the drag law; `mine`: this rank's largest
/// values.
template <bool kA>
void Coupling::Impl::read_particles(Particles& p, double interval, bool polydisperse, Extremes& mine) {
  const bool held = compiled::kHeld && p.some_held();
  const double rho_per_mu = fluid_.density() / fluid_.viscosity(), mu_3pi = 3 * kPi * fluid_.viscosity();
  DragBatch batch;
  const auto finish_batch = [&] {
    batch.find_F(law_);
    for (int l = 0; l < batch.n; ++l) {
      const int i = batch.i[l];
      double* const s = p.state[i];
      const double eps = batch.eps[l], slip = batch.slip[l], m = p.mass[i], per_mass = 1 / m;
      const double b_A = mu_3pi * 2 * p.radius[i] * eps * batch.F[l], b_B = b_A / eps, b = kA ? b_A : b_B;
      s[kDragCoefficient] = b;
      s[kDecay] = plain_decay(b, per_mass);
      s[kResponse] = b_B;
      const double *const v = p.v[i], speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], speed = std::sqrt(speed2);
      mine.speed2 = std::max(mine.speed2, speed2);
      mine.momentum = std::max(mine.momentum, m * speed);
      mine.drag = std::max(mine.drag, b * slip);
      mine.drag_coefficient = std::max(mine.drag_coefficient, b);
      if (!held || !p.held(i)) {
        const double rate = b_B * per_mass;
        mine.drag_number = std::max(mine.drag_number, rate * interval);
        mine.follow = std::max(mine.follow, rate * read_length_ / (slip + speed + 1e-300));
      }
    }
    batch.n = 0;
  };
  double out[Reader::kFields] = {0, 0, 0, 1, 0, 0, 0};
  at_places(p, [&](std::size_t q, int i, const auto& place) {
    double* const s = p.state[i];
    reader_.template at<kA ? 7 : 4>(place, out);
    double slip2 = 0, flux2 = 0;
    for (int d = 0; d < 3; ++d) {
      slip2 += (out[d] - p.v[i][d]) * (out[d] - p.v[i][d]);
      flux2 += flux_velocity_[q][d] * flux_velocity_[q][d];
      s[kImpulse + d] = s[kLateForce + d] = 0;
      s[kFluidVelocity + d] = s[kSeenVelocity + d] = out[d];
    }
    mine.flux2 = std::max(mine.flux2, flux2);
    const double eps = out[Reader::kEps], slip = std::sqrt(slip2), diameter = 2 * p.radius[i];
    const double y = polydisperse ? diameter / motion().diameter(p.x[i]) : 1.0;
    s[kVoidFraction] = eps;
    s[kSizeRatio] = y;
    if (kA) {
      const double volume = sphere_volume(p.radius[i]);
      for (int d = 0; d < 3; ++d) s[kPressureForce + d] = volume * out[Reader::kResidual + d];
    }
    batch.add(i, eps, slip, eps * rho_per_mu * slip * diameter, y);
    if (batch.full()) finish_batch();
  });
  finish_batch();
  mine.momentum = std::max(mine.momentum, extremes_.mass * std::sqrt(mine.flux2));
}

void Coupling::Impl::rebuild_pressure_force(Particles& p) {
  double beta;
  Vec3 drag;
  for (int i : inside_) {
    double* s = p.state[i];
    motion().drag_at(p.x[i], beta, drag);
    const double volume = sphere_volume(p.radius[i]);
    s[kResponse] = s[kDragCoefficient] + volume * beta;
    for (int d = 0; d < 3; ++d) s[kPressureForce + d] += volume * drag[d];
  }
}

void Coupling::Impl::choose_hold(double drag_number) {
  report_.max_drag_number = drag_number;
  if (!compiled::kHold || settings_.one_way || settings_.hold_flux == Choice::kOff)
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
    for (int d = 0; d < 3; ++d)
      last_force_[q][d] = s[kDragCoefficient] * (s[kSeenVelocity + d] - p.v[i][d]) + s[kPressureForce + d];
  }
}

/// What the particles felt between couplings was held; here it jumps to its new value.
void Coupling::Impl::compare_forces(const Particles& p) {
  double sum[2] = {0, 0};
  for (std::size_t q = 0; q < inside_.size(); ++q) {
    const int i = inside_[q];
    const double* s = p.state[i];
    for (int d = 0; d < 3; ++d) {
      const double force = s[kDragCoefficient] * (s[kFluidVelocity + d] - p.v[i][d]) + s[kPressureForce + d];
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
  const Ledger::Balance balance = ledger_.balance(comm_);
  report_.solid_volume = balance.solid_volume;
  report_.solid_volume_error = balance.volume_error;
  if (interval > 0 && !settings_.one_way) report_.momentum_error = balance.momentum_error;
  report_.volume_inserted = balance.inserted_volume;
  report_.volume_vanished = interval > 0 ? known_volume_ + balance.inserted_volume - balance.solid_volume : 0.0;
  if (std::abs(report_.volume_vanished) <= 1e-10 * known_volume_) report_.volume_vanished = 0;  // round-off of the sums
  report_.inserted_total += report_.volume_inserted;
  report_.vanished_total += report_.volume_vanished;
  known_volume_ = balance.solid_volume;
}

// Drag with the exact answer of a linear drag to a constant force (exponential integrator): velocity Verlet moves
// v^{n-1/2} to v^{n+1/2} by one f,
//   f <- phi(k) (f - V_p rho_f g + F),   F = b (u_seen - v) + F_p,   k = c D/m,   phi(k) = (1 - e^-k)/k,   D = dem_dt
//   not holding   u_seen = u_read, c = b
//   holding       u_seen = u_read - C(t), c = b_tot (1 + eps_s/eps); formulation A: F_p grows by V_p P(t)
// monotone for every k. Stiff steps (k > kStiff): stiff_forces().
void Coupling::Impl::force(Particles& p, double dem_dt, bool accumulate) {
  Stopwatch watch(shares_.force);
  const bool hold = compiled::kHold && holding_, held = compiled::kHeld && p.some_held();
  if (hold) motion().update(p);
  stiff_.clear();
  if (hold)
    forces<compiled::kHold, compiled::kHeld>(p, dem_dt, accumulate);
  else if (held)
    forces<false, compiled::kHeld>(p, dem_dt, accumulate);
  else if (accumulate)
    plain_forces(p, dem_dt);
  else
    forces<false, false>(p, dem_dt, false);
}

template <bool kHolding, bool kHeld>
void Coupling::Impl::forces(Particles& p, double dem_dt, bool accumulate) {
  for (int i = 0; i < p.n; ++i)
    if (p.takes_part(i)) force_on<kHolding, kHeld>(p, i, dem_dt, accumulate);
}

/// The common case: nothing held, not in set-up. What every step of every particle costs; the rest is left to
/// force_on().
void Coupling::Impl::plain_forces(Particles& p, double dem_dt) {
  if (dem_dt != decay_dt_) find_decay(p, dem_dt);
  left_.resize(p.n);
  const int left = add_plain_forces(p, {dem_dt, -fluid_.density(), gravity_}, formulation_A(), left_.data());
  for (int q = 0; q < left; ++q) force_on<false, false>(p, left_[q], dem_dt, true);
}

void Coupling::Impl::find_decay(Particles& p, double dem_dt) {
  decay_dt_ = dem_dt;
  for (int i = 0; i < p.n; ++i)
    if (p.takes_part(i)) p.state[i][kDecay] = plain_decay(p.state[i][kDragCoefficient], 1 / p.mass[i]);
}

/// phi(k) of a step for plain_forces(); 0 where it has to look closer.
double Coupling::Impl::plain_decay(double b, double per_mass) const {
  const double k = b * decay_dt_ * per_mass;
  return b > 0 && k <= kStiff ? mean_decay_series(k) : 0.0;
}

template <bool kHolding, bool kHeld>
void Coupling::Impl::force_on(Particles& p, int i, double dem_dt, bool accumulate) {
  const bool A = formulation_A();
  const double lift = -fluid_.density();
  Vec3 c{0, 0, 0}, pressure{0, 0, 0};
  double* s = p.state[i];
  const double b = s[kDragCoefficient];
  const double sphere = sphere_volume(p.radius[i]), buoyancy = b > 0 ? lift * sphere : 0.0;
  double volume = 0, response = b;
  if (kHolding && b > 0) {
    motion().change_at(p.x[i], c, pressure);
    volume = A ? sphere : 0.0;
    response = s[kResponse] / s[kVoidFraction];
  }
  Vec3 other, slip, steady;
  for (int d = 0; d < 3; ++d) {
    s[kSeenVelocity + d] = s[kFluidVelocity + d] - c[d];
    other[d] = p.f[i][d] + buoyancy * gravity_[d];
    slip[d] = s[kSeenVelocity + d] - p.v[i][d];
    steady[d] = other[d] + s[kPressureForce + d] + volume * pressure[d];
  }
  const double k = kHeld && p.held(i) ? 0 : response * dem_dt / p.mass[i];
  const bool stiff = k > kStiff;
  Vec3 first, second;  // forces of the half kicks before and after this step's end
  if (stiff) {
    stiff_.push_back(i);
    stiff_forces(p, i, k / b, dem_dt, steady, slip, accumulate, first, second);
  } else {
    for (int d = 0; d < 3; ++d) first[d] = second[d] = (steady[d] + b * slip[d]) * mean_decay(k);
  }
  for (int d = 0; d < 3; ++d) {
    const double received = 0.5 * (first[d] + second[d]) - other[d];
    // In set-up the force is applied for half a step, in place of the half step that the last one would have had.
    s[kImpulse + d] +=
        accumulate ? received * dem_dt
                   : 0.5 * dem_dt * (received - s[kDragForce + d] - s[kPressureForce + d] - 0.5 * s[kLateForce + d]);
    s[kDragForce + d] = received - s[kPressureForce + d];
    s[kLateForce + d] = second[d] - first[d];
    if (!kHeld || !p.is_frozen(i)) p.f[i][d] = first[d];
  }
}

/// Half kicks of a stiff step such that v at whole steps is the exact answer and v between them, which moves the
/// particle, its exact mean. With G the steady force and w the slip at the mean velocity of the step that ends:
///   end of this step     first  = 2 (G + b w) [1 - (1 - phi)/(k phi)]
///   start of the next    second = 2 (G + b w_n) (1 - phi)/k,   w_n the slip at this step's end
/// b by the drag law at the mean slip of the step in question (that of the next one by iteration). k_per_b = k/b.
void Coupling::Impl::stiff_forces(const Particles& p, int i, double k_per_b, double dem_dt, const Vec3& steady,
                                  const Vec3& slip, bool ends_a_step, Vec3& first, Vec3& second) const {
  const double per_mass = dem_dt / p.mass[i];
  Vec3 end = slip, middle;
  if (ends_a_step) {
    // b at the mean slip; the longer the step, the nearer to the slip at its end, where it settles.
    double b = law_at(p, i, slip);
    for (int round = 0; round <= kStiffRounds; ++round) {
      const double k = k_per_b * b, phi = mean_decay(k), share = 1 - (1 - phi) / (k * phi);
      const double late = -std::expm1(-k * k);
      for (int d = 0; d < 3; ++d) {
        const double kick = (steady[d] + b * slip[d]) * share;
        first[d] = 2 * kick;
        end[d] = slip[d] - kick * per_mass;
        middle[d] = slip[d] + late * (end[d] - slip[d]);
      }
      if (round < kStiffRounds) b = std::sqrt(b * law_at(p, i, middle));
    }
  }
  // b and the mean slip depend on each other; where the drag goes with the square of the slip their product would swing
  // about the answer, and the geometric mean meets it.
  double b = law_at(p, i, end), share = 0;
  for (int round = 0; round <= kStiffRounds; ++round) {
    const double k = k_per_b * b, phi = mean_decay(k);
    share = (1 - phi) / k;
    if (round == kStiffRounds) break;
    double square = 0, mean_square = 0;
    for (int d = 0; d < 3; ++d) {
      const double F = steady[d] + b * end[d], last = end[d] - F * phi * per_mass;
      middle[d] = end[d] - F * share * per_mass;
      square += (end[d] * end[d] + end[d] * last + last * last) / 3;
      mean_square += 0.25 * (end[d] + last) * (end[d] + last);
    }
    // A drag that grows faster than the slip has a mean above that of the mean slip: mean of w^2 over mean of w.
    const double above = mean_square > 0 ? std::min(square / mean_square, 4.0 / 3) : 1.0;
    for (double& w : middle) w *= above;
    b = std::sqrt(b * law_at(p, i, middle));
  }
  for (int d = 0; d < 3; ++d) second[d] = 2 * (steady[d] + b * end[d]) * share;
  if (!ends_a_step) first = second;
}

/// The drag coefficient b_p for another slip than that of the last coupling, at the same eps and size.
double Coupling::Impl::law_at(const Particles& p, int i, const Vec3& slip) const {
  const double* s = p.state[i];
  const double magnitude = std::sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
  const double b_A = drag_coefficient(law_, s[kVoidFraction], 2 * p.radius[i], magnitude, fluid_.density(),
                                      fluid_.viscosity(), s[kSizeRatio]);
  return formulation_A() ? b_A : b_A / s[kVoidFraction];
}

void Coupling::Impl::finish_step(Particles& p) {
  for (int i : stiff_)
    for (int d = 0; d < 3; ++d) p.f[i][d] += p.state[i][kLateForce + d];
}

Coupling::Coupling(MPI_Comm comm, const Settings& settings, Fluid& fluid, const Vec3& sub_lo, const Vec3& sub_hi,
                   double reach)
    : impl_(std::make_unique<Impl>(comm, settings, fluid, ParticleRegion{sub_lo, sub_hi, reach})) {}

Coupling::~Coupling() = default;

void Coupling::start(Particles& p, double dem_dt) {
  impl_->start(p, dem_dt);
}
void Coupling::advance(Particles& p, int steps, double dem_dt, bool check) {
  impl_->advance(p, steps, dem_dt, check);
}
void Coupling::force(Particles& p, double dem_dt, bool accumulate) {
  impl_->force(p, dem_dt, accumulate);
}
void Coupling::finish_step(Particles& p) {
  impl_->finish_step(p);
}
void Coupling::repeat_force() {
  impl_->repeat_force();
}
void Coupling::set_gravity(const Vec3& g) {
  impl_->gravity_ = g;
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
