#include "cfd/fluid_solver.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/momentum/viscous_solver.h"
#include "cfd/parallel/reduction.h"
#include "cfd/parallel/vectorised.h"
#include "cfd/pressure/pressure_solver.h"

namespace twogrid {

namespace {

/// Share of the wanted Courant number for which a new step is chosen, and number of steps that could have been longer
/// before it grows.
constexpr double kChosenCfl = 0.8;
constexpr int kIdleSteps = 30;

const FluidSettings& checked(const FluidSettings& s, const FineGrid& grid) {
  s.check(grid);
  s.check_flow(grid);
  return s;
}

int rank_of(MPI_Comm comm) {
  int r;
  MPI_Comm_rank(comm, &r);
  return r;
}

std::vector<Box> with_halo(const std::vector<Box>& cells, const Int3& halo) {
  std::vector<Box> wanted;
  for (const Box& b : cells) wanted.push_back(b.empty() ? Box{} : b.grown(halo));
  return wanted;
}

void reset(FaceField<FineGrid>& f, const Box& box) {
  for (auto& c : f) c.reset(box);
}

void copy(const Array3<double>& from, Array3<double>& to, const Box& box) {
  for_each(box, [&](int i, int j, int k) { to(i, j, k) = from(i, j, k); });
}

/// All faces of the cells, in one box for the three directions.
Box faces_around(const Box& own, const Int3& halo) {
  Box b = own;
  for (int d = 0; d < 3 && !own.empty(); ++d) b.hi[d] += std::min(halo[d], 1);
  return b;
}

/// Measures of a row of faces normal to d, or of the cells above them, from (i,j,k) on.
template <int d>
struct RowMeasure {
  static constexpr int e = (d + 1) % 3, f = (d + 2) % 3;
  AlongRow<d == 0> below, above, inverse_width;
  AlongRow<e == 0> we;
  AlongRow<f == 0> wf;

  RowMeasure(const Momentum& m, const Int3& x)
      : below(along_row<d>(m.axis(d).half_below_, x[d] - m.axis(d).lo)),
        above(along_row<d>(m.axis(d).half_above_, x[d] - m.axis(d).lo)),
        inverse_width(along_row<d>(m.axis(d).inverse_face_width_, x[d] - m.axis(d).lo)),
        we(along_row<e>(m.axis(e).width_, x[e] - m.axis(e).lo)),
        wf(along_row<f>(m.axis(f).width_, x[f] - m.axis(f).lo)) {}
  double area(int t) const { return we[t] * wf[t]; }
  double volume(int t) const { return (below[t] + above[t]) * we[t] * wf[t]; }
};

/// Calls f(first index of the row, its memory index in `like`) for each row of the box.
template <class F>
inline void for_each_row(const Box& b, const Array3<double>& like, F&& f) {
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) f(Int3{b.lo[0], j, k}, like.index(b.lo[0], j, k));
}

TWOGRID_VECTORISED void extrapolate_values(std::size_t n, double r, const double* now, const double* old,
                                           double* __restrict out) {
  for (std::size_t m = 0; m < n; ++m) out[m] = now[m] + r * (now[m] - old[m]);
}

TWOGRID_VECTORISED void extrapolate_values(std::size_t n, double r, double older_share, const double* now,
                                           const double* old, const double* older, double* __restrict out) {
  for (std::size_t m = 0; m < n; ++m) out[m] = now[m] + r * (now[m] - old[m]) - older_share * (old[m] - older[m]);
}

/// From memory index `first` of the path's fields on.
TWOGRID_VECTORISED void void_fraction_at(const VoidFractionInTime& eps, double s, double interval, std::ptrdiff_t first,
                                         std::size_t n, double* __restrict out) {
  const VoidFractionInTime path = eps;
  for (std::size_t m = 0; m < n; ++m) out[m] = path.at(first + std::ptrdiff_t(m), s, interval);
}

}  // namespace

FluidSolver::FluidSolver(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings)
    : comm_(comm),
      rank_(rank_of(comm)),
      grid_(grid),
      layout_(layout),
      settings_(checked(settings, grid)),
      own_(layout.cells(rank_)),
      boundaries_(comm, grid_, layout_, settings_),
      local_(boundaries_.local()),
      faces_{own_.empty() ? Box{} : layout.faces(0, rank_), own_.empty() ? Box{} : layout.faces(1, rank_),
             own_.empty() ? Box{} : layout.faces(2, rank_)},
      momentum_(grid_, own_, local_, faces_,
                {boundaries_.component_solved(0), boundaries_.component_solved(1), boundaries_.component_solved(2)}),
      row_a_(local_.size(0)),
      row_b_(local_.size(0)) {
  const auto wanted = with_halo(layout_.all_cells(), boundaries_.halo());
  cell_halo_ = BlockExchange(comm_, layout_.all_cells(), wanted, grid_.n(), grid_.periodic());
  face_halo_ = FaceExchange(comm_, {layout_.all_faces(0), layout_.all_faces(1), layout_.all_faces(2)},
                            {wanted, wanted, wanted}, grid_.n(), grid_.periodic());
  pressure_solver_ =
      std::make_unique<PressureSolver>(comm_, grid_, layout_, settings_.pressure_rtol, boundaries_.halo());

  for (auto* f : {&state_.u, &state_.u_old, &u_tilde_, &u_next_, &state_.eps_f}) reset(*f, local_);
  if (central()) reset(state_.u_older, local_);
  for (auto& level : state_.eps) level.reset(local_, 1.0);
  for (auto* c : {&state_.p, &state_.phi}) c->reset(local_);
  imbalance_.reset(own_);
  state_.imposed = settings_.pressure_gradient;
}

FluidSolver::~FluidSolver() = default;

void FluidSolver::fill(FaceField<FineGrid>& u, bool ghosts) const {
  face_halo_.bring(u);
  if (ghosts) boundaries_.apply(u);
}

/// eps on the faces from that of the cells, halo filled.
void FluidSolver::set_face_eps() {
  momentum_.face_mean(state_.eps[0], state_.eps_f);
  boundaries_.apply_face_eps(state_.eps_f);
  face_halo_.bring(state_.eps_f);
}

void FluidSolver::fill(CellField<FineGrid>& c) const {
  cell_halo_.bring<double>(c);
}

void FluidSolver::start(const CellField<FineGrid>& eps) {
  state_.time = 0;
  state_.dt_previous = state_.dt_older = 0;
  copy(eps, state_.eps[0], local_);
  set_face_eps();
  state_.eps[1] = state_.eps[0];
  state_.p.fill(0);
  state_.phi.fill(0);
  for (int d = 0; d < 3; ++d) state_.u[d].fill(boundaries_.component_solved(d) ? settings_.initial_velocity[d] : 0.0);
  if (settings_.initial_vortex != 0) add_vortex();
  boundaries_.update();
  fill(state_.u);
  make_continuous();
  state_.u_old = state_.u;
  state_.one_step = true;
  for (auto& g : state_.mean_grad_p) g.fill(0);
}

/// Adds u = U sin(kx x) cos(ky y), v = -U kx/ky cos(kx x) sin(ky y), one wavelength over the domain's x and y.
void FluidSolver::add_vortex() {
  const Axis &x = grid_.axis[0], &y = grid_.axis[1];
  const double kx = 2 * std::acos(-1.0) / x.length(), ky = 2 * std::acos(-1.0) / y.length(),
               U = settings_.initial_vortex;
  for_each(faces_[0], [&](int i, int j, int k) {
    state_.u[0](i, j, k) += U * std::sin(kx * (x.node(i) - x.lo())) * std::cos(ky * (y.centre(j) - y.lo()));
  });
  for_each(faces_[1], [&](int i, int j, int k) {
    state_.u[1](i, j, k) -= U * kx / ky * std::cos(kx * (x.centre(i) - x.lo())) * std::sin(ky * (y.node(j) - y.lo()));
  });
}

/// Projects the initial u onto one that satisfies continuity with eps at rest: a run that starts with its inlets open
/// then starts without the infinite pressure of an impulsive start.
void FluidSolver::make_continuous() {
  for (int d = 0; d < 3; ++d) u_next_[d] = state_.u[d];
  inertia_per_eps_ = settings_.density;
  FluidReport report;
  project(Step{1, 0, 1, -1, 0}, Interphase{}, report);
  correct();
  for (int d = 0; d < 3; ++d) state_.u[d].swap(u_next_[d]);
}

void FluidSolver::set_state(double time, const FaceField<FineGrid>& u, const CellField<FineGrid>& p,
                            const CellField<FineGrid>& eps, double dt_previous, const FaceField<FineGrid>& u_previous,
                            const CellField<FineGrid>& eps_previous) {
  state_.time = time;
  state_.dt_previous = dt_previous, state_.dt_older = 0;
  boundaries_.update();
  for (int d = 0; d < 3; ++d) copy(u[d], state_.u[d], faces_[d]), copy(u_previous[d], state_.u_old[d], faces_[d]);
  fill(state_.u);
  fill(state_.u_old);
  copy(p, state_.p, own_);
  fill(state_.p);
  copy(eps, state_.eps[0], local_);
  copy(eps_previous, state_.eps[1], local_);
  set_face_eps();
}

FluidReport FluidSolver::advance(double interval, const VoidFractionInTime& eps, const Interphase& exchange) {
  FluidReport report;
  if (exchange.replaced) replace(*eps.begin, exchange.same_flux);
  begin_means();
  double done = 0;
  while (done < interval * (1 - 1e-12)) {
    boundaries_.update();
    Step step = formula(allowed_dt(interval - done, interval));
    for (;;) {
      next_level(eps, std::min(1.0, (done + step.dt) / interval), interval);
      extrapolate(step);
      predict(step, exchange);
      project(step, exchange, report);
      correct();
      hold_flow_rate(exchange);
      const double cfl = courant_rate(u_next_) * step.dt;
      if (!std::isfinite(cfl)) {
        std::ostringstream text;
        text << "the fluid's velocity is not finite at t = " << state_.time + step.dt << " s (fluid step " << step.dt
             << " s); wanted: finite values; lower 'cfl' (" << settings_.cfl << ") or 'every', or coarsen 'fine'";
        throw std::runtime_error(text.str());
      }
      // A sudden inflow may break the limit only after the projection has seen it: take the step again, smaller.
      if (cfl <= settings_.cfl || settings_.convection == Convection::kNone || settings_.dt > 0) {
        report.cfl = std::max(report.cfl, cfl);
        break;
      }
      previous_level();
      const double left = interval - done;
      step = formula(left / std::ceil(left / (step.dt * std::min(0.75, kChosenCfl * settings_.cfl / cfl))));
      state_.idle_steps = 0;
      refuse_steps_below(step.dt, interval);
    }
    accept(step, interval);
    measure(step, step.dt / interval, report);
    if (implicit_viscosity_) rotate_pressure();
    done += step.dt;
    if (after_step_ && done < interval * (1 - 1e-12)) after_step_(report.steps, done / interval);
  }
  return report;
}

void FluidSolver::begin_means() {
  state_.one_step = false;
  for (auto& u : state_.mean_u) u.fill(0);
  if (!keep_grad_p_) return;
  if (state_.mean_grad_p[0].size() == 0) reset(state_.mean_grad_p, faces_around(own_, boundaries_.halo()));
  for (auto& g : state_.mean_grad_p) g.fill(0);
}

FluidReport FluidSolver::advance_and_check(double interval, const VoidFractionInTime& eps, const Interphase& exchange) {
  const bool kept = keep_grad_p_;
  keep_grad_p_ = true;
  FluidState begin = state_;
  FluidReport report = advance(interval, eps, exchange);
  FluidState end = std::move(state_);
  state_ = std::move(begin);
  const double dt = settings_.dt;
  settings_.dt = 0.5 * interval / report.steps;
  advance(interval, eps, exchange);
  settings_.dt = dt;
  report.step_error = difference_from(end);
  state_ = std::move(end);
  keep_grad_p_ = kept;
  if (!kept) state_.mean_grad_p = {};
  return report;
}

double FluidSolver::difference_from(const FluidState& other) const {
  double sum[4] = {0, 0, 0, 0};  // (difference of eps u)^2, (eps u)^2; difference of grad p . grad p, (grad p)^2
  for (int d = 0; d < 3; ++d)
    for_each(faces_[d], [&](int i, int j, int k) {
      const double V = momentum_.volume(d, i, j, k);
      const double u = flux(d, i, j, k), g = state_.mean_grad_p[d](i, j, k);
      const double du = u - other.eps_f[d](i, j, k) * other.u[d](i, j, k), dg = g - other.mean_grad_p[d](i, j, k);
      sum[0] += V * du * du, sum[1] += V * u * u;
      sum[2] += V * dg * g, sum[3] += V * g * g;
    });
  MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPI_DOUBLE, MPI_SUM, comm_);
  return std::max(sum[1] > 0 ? std::sqrt(sum[0] / sum[1]) : 0.0, sum[3] > 0 ? std::abs(sum[2]) / sum[3] : 0.0);
}

FluidSolver::Step FluidSolver::formula(double dt) const {
  Step s;
  s.dt = dt;
  s.r = state_.dt_previous > 0 ? dt / state_.dt_previous : 0;
  s.a0 = (1 + 2 * s.r) / (1 + s.r);
  s.a1 = -(1 + s.r);
  s.a2 = s.r * s.r / (1 + s.r);
  if (central() && state_.dt_older > 0) {
    const double dt1 = state_.dt_previous, dt2 = state_.dt_older, share = 0.5 * dt * (dt + dt1) / (dt1 + dt2);
    s.s1 = share / dt1, s.s2 = share / dt2;
  }
  return s;
}

TWOGRID_VECTORISED void FluidSolver::courant_rows(const FaceField<FineGrid>& u, double& rate, double& finite) const {
  const int n = own_.size(0);
  const std::ptrdiff_t sy = state_.p.stride(1), sz = state_.p.stride(2);
  double* __restrict most = row_a_.data(), * __restrict sum = row_b_.data();
  std::fill_n(most, n, 0.0), std::fill_n(sum, n, 0.0);
  for_each_row(own_, state_.p, [&](const Int3& q, std::ptrdiff_t m) {
    const double* ix = &momentum_.axis(0).inverse_width_[q[0] - momentum_.axis(0).lo];
    const double iy = momentum_.axis(1).inverse_width_[q[1] - momentum_.axis(1).lo];
    const double iz = momentum_.axis(2).inverse_width_[q[2] - momentum_.axis(2).lo];
    const double *ux = u[0].data() + m, *uy = u[1].data() + m, *uz = u[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x = std::max(std::abs(ux[i]), std::abs(ux[i + 1])) * ix[i];
      const double y = std::max(std::abs(uy[i]), std::abs(uy[i + sy])) * iy;
      const double z = std::max(std::abs(uz[i]), std::abs(uz[i + sz])) * iz;
      most[i] = std::max(most[i], x + y + z);
      sum[i] += x + y + z;
    }
  });
  for (int i = 0; i < n; ++i) rate = std::max(rate, most[i]), finite += sum[i];
}

double FluidSolver::courant_rate(const FaceField<FineGrid>& u) const {
  double rate = 0, finite = 0;
  courant_rows(u, rate, finite);
  if (!std::isfinite(finite)) rate = INFINITY;
  MPI_Allreduce(MPI_IN_PLACE, &rate, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return rate;
}

/// The step changes only when it must: backward differences with a varying step don't hand on momentum exactly, and
/// where the particles' noise decides both the step and the gas's acceleration, the errors would add up to a force. So
/// a new step is chosen below the limit, kept as long as the limit allows it, and grows only after many steps that
/// could have been longer.
double FluidSolver::allowed_dt(double left, double interval) {
  boundaries_.apply_normal(state_.u);
  double limit = settings_.dt > 0 ? settings_.dt : interval, chosen = limit;
  if (settings_.convection != Convection::kNone && settings_.dt == 0) {
    const double rate = courant_rate(state_.u);
    if (rate > 0)
      limit = std::min(limit, settings_.cfl / rate), chosen = std::min(chosen, kChosenCfl * settings_.cfl / rate);
    if (state_.dt_previous > 0)
      chosen = std::min(chosen, 2 * state_.dt_previous);  // BDF2 is zero-stable up to a ratio of 2.41
  }
  // Extrapolated viscous terms: BDF2 is stable up to a step of 1/3 h^2/nu in one direction, 3/4 of it for div(tau); with
  // the extrapolation of central convection 1/5, and together with convection at the largest Courant number 0.12.
  double widest = 0;
  for (int d = 0; d < 3; ++d) {
    double h = INFINITY;
    for (int i = 0; i < grid_.axis[d].n(); ++i) h = std::min(h, grid_.axis[d].width(i));
    if (boundaries_.component_solved(d) || grid_.axis[d].n() > 1) widest += 1 / (h * h);
  }
  const double viscous_limit = (central() ? 0.12 : 0.2) * settings_.density / (settings_.viscosity * widest + 1e-300);
  implicit_viscosity_ = settings_.implicit_viscosity == Choice::kOn ||
                        (settings_.implicit_viscosity == Choice::kAuto && viscous_limit < chosen);
  if (!implicit_viscosity_ && settings_.dt == 0)
    limit = std::min(limit, viscous_limit), chosen = std::min(chosen, viscous_limit);
  refuse_steps_below(limit, interval);
  const double wanted = left / std::ceil(left / std::min(chosen, left) - 1e-9);
  if (state_.dt_previous > 0 && settings_.dt == 0 && state_.dt_previous <= limit * (1 + 1e-9)) {
    const double parts = std::round(interval / state_.dt_previous), steps = left / state_.dt_previous;
    const bool fits = steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-6;
    state_.idle_steps = parts > 1 && chosen > 0.999 * interval / (parts - 1) ? state_.idle_steps + 1 : 0;
    if (fits && (state_.idle_steps < kIdleSteps || wanted < state_.dt_previous)) return left / std::round(steps);
  }
  state_.idle_steps = 0;
  return wanted;
}

/// An interval of more fluid steps than this is a mistake in the script, and would seem to hang.
void FluidSolver::refuse_steps_below(double limit, double interval) const {
  if (limit * kMostSteps >= interval) return;
  std::ostringstream text;
  text << "a coupling interval of " << interval << " s would need " << interval / limit << " fluid steps of " << limit
       << " s, wanted: at most " << kMostSteps << "; ";
  if (settings_.dt > 0 && limit >= settings_.dt)
    text << "raise 'dt' (" << settings_.dt << " s), or lower 'every' or the DEM timestep";
  else
    text << "look for an inlet or particles too fast and for fine cells too small ('fine', 'stretch'); else lower "
            "'every' or the DEM timestep, or raise 'cfl' ("
         << settings_.cfl << ")" << (settings_.implicit_viscosity == Choice::kOff ? ", or say 'implicit auto'" : "");
  throw std::runtime_error(text.str());
}

void FluidSolver::next_level(const VoidFractionInTime& eps, double s, double interval) {
  std::swap(state_.eps[1], state_.eps[2]);
  std::swap(state_.eps[0], state_.eps[1]);
  if (eps.begin->box() == local_)
    void_fraction_at(eps, s, interval, 0, state_.eps[0].size(), state_.eps[0].data());
  else
    for (int k = local_.lo[2]; k < local_.hi[2]; ++k)
      for (int j = local_.lo[1]; j < local_.hi[1]; ++j)
        void_fraction_at(eps, s, interval, eps.begin->index(local_.lo[0], j, k), local_.size(0),
                         state_.eps[0].data() + state_.eps[0].index(local_.lo[0], j, k));
  set_face_eps();
}

/// What came or went changes eps at once, in the past levels too: no velocity follows from it.
void FluidSolver::replace(const CellField<FineGrid>& now, bool same_flux) {
  const auto by_eps = [&](bool times) {
    for (int d = 0; d < 3; ++d)
      for_each(faces_[d], [&](int i, int j, int k) {
        const double now = state_.eps_f[d](i, j, k), before = momentum_.face_mean(state_.eps[1], d, i, j, k);
        state_.u[d](i, j, k) *= times ? now : 1 / now;
        state_.u_old[d](i, j, k) *= times ? before : 1 / before;
      });
  };
  if (same_flux) by_eps(true);
  for_each(local_, [&](int i, int j, int k) {
    const std::ptrdiff_t m = state_.p.index(i, j, k);
    double &e0 = state_.eps[0].data()[m], &e1 = state_.eps[1].data()[m];
    const double change = now(i, j, k) - e0;
    e0 = now(i, j, k);
    e1 = std::max(e1 + change, 0.5 * std::min(e1, e0));
  });
  set_face_eps();
  if (!same_flux) return;
  by_eps(false);
  boundaries_.apply_normal(state_.u);
  fill(state_.u);
  fill(state_.u_old);
  state_.dt_older = 0;  // u^{n-2} is not carried over
}

void FluidSolver::previous_level() {
  std::swap(state_.eps[0], state_.eps[1]);
  std::swap(state_.eps[1], state_.eps[2]);
}

void FluidSolver::extrapolate(const Step& step) {
  for (int d = 0; d < 3; ++d)
    if (step.s2 != 0)
      extrapolate_values(state_.u[d].size(), step.r + step.s1, step.s2, state_.u[d].data(), state_.u_old[d].data(),
                         state_.u_older[d].data(), u_tilde_[d].data());
    else
      extrapolate_values(state_.u[d].size(), step.r, state_.u[d].data(), state_.u_old[d].data(), u_tilde_[d].data());
  boundaries_.apply(u_tilde_);
}

bool FluidSolver::has(int side, BoundaryKind kind) const {
  for (const BoundaryCondition& c : settings_.side[side])
    if (c.kind == kind) return true;
  return false;
}

/// An inlet's pressure is the one that, with the momentum rho F u entering, balances pressure and momentum flux at the
/// first cell's centre, where the first solved volume begins: p_in A = p_cell A + rho (F u)_cell - rho (F u)_face.
void FluidSolver::measure_inlet_head() {
  inlet_head_ = 0;
  if (settings_.convection == Convection::kNone) return;
  const double rho = settings_.density;
  for (int side = 0; side < 6; ++side) {
    if (!has(side, BoundaryKind::kInlet)) continue;
    boundaries_.for_each_face(side, [&](int, int i, int j, int k) {
      if (boundaries_.kind(side, i, j, k) != BoundaryKind::kInlet) return;
      const int d = direction(side);
      Int3 in{i, j, k};
      if (is_high(side)) --in[d];
      inlet_head_ +=
          momentum_.convected_through(d, in[0], in[1], in[2], rho, state_.eps_f, u_tilde_, settings_.convection) -
          rho * (state_.eps_f[d](i, j, k) * u_tilde_[d](i, j, k)) * u_tilde_[d](i, j, k) * grid_.area(d, i, j, k);
    });
  }
}

/// A of a row of faces.
inline void FluidSolver::inertia_row(const double* e, const double* beta, int n, double* __restrict A) const {
  for (int i = 0; i < n; ++i) A[i] = inertia_per_eps_ * e[i];
  if (!beta) return;
  for (int i = 0; i < n; ++i) A[i] += beta[i];
}

/// On top of convection and viscosity in rhs: pressure, history, exchange; then u*. rhs may be u_next_ itself.
template <int d>
inline void FluidSolver::predict_component(const Step& step, const Interphase& exchange, FaceField<FineGrid>& rhs) {
  const double rho = settings_.density, imposed = state_.imposed[d];
  const double c1 = rho * step.a1 / step.dt, c2 = rho * step.a2 / step.dt;
  const std::ptrdiff_t s = state_.p.stride(d);
  const int n = faces_[d].size(0);
  double* __restrict A = row_a_.data();
  for_each_row(faces_[d], state_.p, [&](const Int3& x, std::ptrdiff_t m) {
    const RowMeasure<d> row(momentum_, x);
    const auto share = along_row<d>(momentum_.axis(d).above_share_, x[d] - momentum_.axis(d).lo);
    const double *p = state_.p.data() + m, *now = state_.u[d].data() + m, *old = state_.u_old[d].data() + m;
    const double *e1 = state_.eps[1].data() + m, *e2 = state_.eps[2].data() + m;
    double *o = rhs[d].data() + m, *next = u_next_[d].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) o[i] -= ((p[i] - p[i - s]) * row.inverse_width[i] + imposed) * row.volume(i);
    if (const double* source = exchange.source_row(d, x[0], x[1], x[2], n, row_b_.data())) {
#pragma GCC ivdep
      for (int i = 0; i < n; ++i) o[i] += source[i] * row.volume(i);
    }
    inertia_row(state_.eps_f[d].data() + m, exchange.beta_row(d, x[0], x[1], x[2], n, row_b_.data()), n, A);
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double V = row.volume(i);
      // eps on the faces at the levels before; wrong on prescribed faces, whose u* apply_normal() overwrites.
      const double f1 = e1[i - s] + share[i] * (e1[i] - e1[i - s]), f2 = e2[i - s] + share[i] * (e2[i] - e2[i - s]);
      const double sum = o[i] - (c1 * f1 * now[i] + c2 * f2 * old[i]) * V;
      o[i] = sum;
      next[i] = sum / (A[i] * V);
    }
    if (inertia_[d].size() > 0) std::copy_n(A, n, inertia_[d].data() + m);
  });
}

TWOGRID_VECTORISED void FluidSolver::predict_rows(const Step& step, const Interphase& exchange,
                                                  FaceField<FineGrid>& rhs) {
  if (boundaries_.component_solved(0)) predict_component<0>(step, exchange, rhs);
  if (boundaries_.component_solved(1)) predict_component<1>(step, exchange, rhs);
  if (boundaries_.component_solved(2)) predict_component<2>(step, exchange, rhs);
}

void FluidSolver::predict(const Step& step, const Interphase& exchange) {
  const double rho = settings_.density, mu = settings_.viscosity;
  const bool implicit = implicit_viscosity_ && mu > 0;
  if (implicit && inertia_[0].size() == 0) reset(rhs_, local_), reset(inertia_, local_);
  FaceField<FineGrid>& rhs = implicit ? rhs_ : u_next_;
  for (auto& c : rhs) c.fill(0);
  momentum_.convect(rho, state_.eps_f, u_tilde_, settings_.convection, rhs);
  measure_inlet_head();
  if (mu > 0 && !implicit_viscosity_) momentum_.viscous(mu, state_.eps[0], u_tilde_, rhs);
  boundaries_.set_outlet_pressure(u_tilde_, rho);
  boundaries_.apply_pressure(state_.p);

  const bool gap = settings_.gap_friction;
  double friction = 0;  // of the walls of a one-cell gap, 12 mu/W^2
  for (int d = 0; gap && d < 3; ++d)
    if (!boundaries_.component_solved(d)) friction = 12 * mu / (grid_.axis[d].length() * grid_.axis[d].length());
  inertia_per_eps_ = rho * step.a0 / step.dt + friction;
  predict_rows(step, exchange, rhs);
  for (int d = 0; d < 3; ++d)
    if (!boundaries_.component_solved(d)) u_next_[d].fill(0);
  boundaries_.apply_normal(u_next_);
  if (implicit) {
    if (!viscous_solver_)
      viscous_solver_ = std::make_unique<ViscousSolver>(comm_, boundaries_, momentum_, faces_, local_, face_halo_);
    viscous_solver_->solve(mu, state_.eps[0], inertia_, rhs_, u_next_);
  }
}

template <int d>
inline void FluidSolver::conductance_component(const Interphase& exchange) {
  const int n = faces_[d].size(0);
  double* __restrict A = row_a_.data();
  for_each_row(faces_[d], state_.p, [&](const Int3& x, std::ptrdiff_t m) {
    const RowMeasure<d> row(momentum_, x);
    const double* e = state_.eps_f[d].data() + m;
    double* __restrict g = conductance_[d].data() + m;
    inertia_row(e, exchange.beta_row(d, x[0], x[1], x[2], n, row_b_.data()), n, A);
    for (int i = 0; i < n; ++i) g[i] = e[i] / A[i] * row.area(i) * row.inverse_width[i];
  });
}

TWOGRID_VECTORISED void FluidSolver::conductance_rows(const Interphase& exchange) {
  for (int d = 0; d < 3; ++d)
    if (!boundaries_.component_solved(d)) conductance_[d].fill(0);
  if (boundaries_.component_solved(0)) conductance_component<0>(exchange);
  if (boundaries_.component_solved(1)) conductance_component<1>(exchange);
  if (boundaries_.component_solved(2)) conductance_component<2>(exchange);
}

/// Conductance of faces: eps/A times area over the distance of the centres; half of it at an outlet, none through
/// prescribed faces.
void FluidSolver::set_conductance(const Interphase& exchange) {
  conductance_rows(exchange);
  for (int side = 0; side < 6; ++side)
    boundaries_.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      conductance_[d](i, j, k) *= boundaries_.state(d)(i, j, k) == FaceState::kFixed ? 0 : 2;
    });
}

/// imbalance_: what is missing in continuity, sum of eps u* A + (d(eps)/dt - q) V, and its sum; scale: the largest
/// |eps u*|.
TWOGRID_VECTORISED void FluidSolver::missing_continuity(double& scale, double& sum) {
  const FluidState::Rate rate = state_.rate;
  const std::ptrdiff_t sy = state_.p.stride(1), sz = state_.p.stride(2);
  const int n = own_.size(0);
  double* __restrict most = row_a_.data(), * __restrict total = row_b_.data();
  std::fill_n(most, n, 0.0), std::fill_n(total, n, 0.0);
  for_each_row(own_, state_.p, [&](const Int3& q, std::ptrdiff_t m) {
    const double* wx = &momentum_.axis(0).width_[q[0] - momentum_.axis(0).lo];
    const double wy = momentum_.axis(1).width(q[1]), wz = momentum_.axis(2).width(q[2]);
    double* __restrict b = imbalance_.data() + imbalance_.index(q[0], q[1], q[2]);
    const double *ex = state_.eps_f[0].data() + m, *ey = state_.eps_f[1].data() + m, *ez = state_.eps_f[2].data() + m;
    const double *ux = u_next_[0].data() + m, *uy = u_next_[1].data() + m, *uz = u_next_[2].data() + m;
    const double *e0 = state_.eps[0].data() + m, *e1 = state_.eps[1].data() + m, *e2 = state_.eps[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x0 = ex[i] * ux[i], x1 = ex[i + 1] * ux[i + 1];
      const double y0 = ey[i] * uy[i], y1 = ey[i + sy] * uy[i + sy];
      const double z0 = ez[i] * uz[i], z1 = ez[i + sz] * uz[i + sz];
      const double void_fraction_rate = rate.b0 * e0[i] + rate.b1 * e1[i] + rate.b2 * e2[i];
      b[i] = (x1 - x0) * (wy * wz) + (y1 - y0) * (wz * wx[i]) + (z1 - z0) * (wx[i] * wy) +
             void_fraction_rate * (wx[i] * wy * wz);
      total[i] += b[i];
      const double x = std::max(std::abs(x0), std::abs(x1)), y = std::max(std::abs(y0), std::abs(y1)),
                   z = std::max(std::abs(z0), std::abs(z1));
      most[i] = std::max(most[i], std::max(x, std::max(y, z)));
    }
  });
  for (int i = 0; i < n; ++i) scale = std::max(scale, most[i]), sum += total[i];
}

void FluidSolver::project(const Step& step, const Interphase& exchange, FluidReport& report) {
  face_halo_.bring(u_next_);
  boundaries_.apply_normal(u_next_);

  set_conductance(exchange);
  double scale = 0, sum = 0;
  state_.rate = {step.a0 / step.dt, step.a1 / step.dt, step.a2 / step.dt, 0};
  missing_continuity(scale, sum);
  double total_volume = 1;
  for (int d = 0; d < 3; ++d) total_volume *= grid_.axis[d].length();
  double whole = sum;
  Reduction::over_ranks(comm_, {&scale}, {&whole});
  state_.velocity_scale = scale;
  if (!boundaries_.open()) {
    // A closed or periodic domain: what is left over is the round-off of the solid volume's conservation.
    state_.rate.excess = whole / total_volume;
    for_each(own_, [&](int i, int j, int k) { imbalance_(i, j, k) -= state_.rate.excess * grid_.volume(i, j, k); });
  }
  if (implicit_viscosity_) divergence_ = imbalance_;
  pressure_solver_->set_operator(conductance_, !boundaries_.open());
  // Continuity error wanted: |r| h/(U V) <= rtol in the root mean square over cells.
  const double cells = double(grid_.n()[0]) * grid_.n()[1] * grid_.n()[2];
  const double cell_volume = total_volume / cells, h = std::cbrt(cell_volume);
  // Not below what rounding leaves of the flows and of the differences of eps.
  const double rounding = 4e-16 * (6 * scale / h + step.a0 / step.dt);
  const double atol = std::max(pressure_solver_->rtol() * scale / h, rounding) * cell_volume * std::sqrt(cells);
  // First guess: the pressure goes on changing as in the last step.
  for (std::size_t m = 0; m < state_.phi.size(); ++m) state_.phi.data()[m] *= step.r;
  report.pressure_iterations += pressure_solver_->solve(imbalance_, state_.phi, atol);
  if (boundaries_.open()) balance_outlets(sum);
}

/// Continuity of the whole domain, of which the solver has left a part of its tolerance: phi is raised by what makes
/// the outlets let out the rest. No other face feels it. sum: the rank's own imbalance before the solve (m3/s).
/// Collective.
void FluidSolver::balance_outlets(double sum) {
  double flow[3] = {sum, 0, 0};  // m3/s: missing; let out by phi; by one of 1 Pa
  for (int side = 0; side < 6; ++side)
    boundaries_.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      const double g = conductance_[d](i, j, k);
      const std::ptrdiff_t cell = state_.phi.index(i, j, k) - (side % 2 == 1 ? state_.phi.stride(d) : 0);
      flow[1] += g * state_.phi.data()[cell];
      flow[2] += g;
    });
  MPI_Allreduce(MPI_IN_PLACE, flow, 3, MPI_DOUBLE, MPI_SUM, comm_);
  if (!(flow[2] > 0)) return;
  const double rise = -(flow[0] + flow[1]) / flow[2];
  for_each(own_, [&](int i, int j, int k) { state_.phi(i, j, k) += rise; });
}

/// u^{n+1} = u* - grad phi/A, with 1/A from the conductance: g = eps/A area/distance.
template <int d>
inline void FluidSolver::correct_component() {
  const std::ptrdiff_t s = state_.p.stride(d);
  const int n = faces_[d].size(0);
  for_each_row(faces_[d], state_.p, [&](const Int3& x, std::ptrdiff_t m) {
    const RowMeasure<d> row(momentum_, x);
    const double *g = conductance_[d].data() + m, *e = state_.eps_f[d].data() + m, *f = state_.phi.data() + m;
    double* __restrict u = u_next_[d].data() + m;
    for (int i = 0; i < n; ++i) u[i] -= g[i] / (e[i] * row.area(i)) * (f[i] - f[i - s]);
  });
}

TWOGRID_VECTORISED void FluidSolver::correct_rows() {
  if (boundaries_.component_solved(0)) correct_component<0>();
  if (boundaries_.component_solved(1)) correct_component<1>();
  if (boundaries_.component_solved(2)) correct_component<2>();
}

void FluidSolver::correct() {
  fill(state_.phi);
  // An outlet's conductance is that of half the distance: its ghost is zero at the face itself.
  boundaries_.apply_correction(state_.phi);
  correct_rows();
  fill(u_next_);
}

/// After everything that the fluid felt (p^n + phi) has been measured.
void FluidSolver::rotate_pressure() {
  for_each(own_, [&](int i, int j, int k) {
    state_.p(i, j, k) -= 4.0 / 3.0 * settings_.viscosity * divergence_(i, j, k) / grid_.volume(i, j, k);
  });
  fill(state_.p);
  boundaries_.apply_pressure(state_.p);
}

void FluidSolver::hold_flow_rate(const Interphase& exchange) {
  for (int d = 0; d < 3; ++d) {
    if (!settings_.flow_rate_set[d]) continue;
    // Potential that answers a unit mean gradient in d: div(g (grad response + e_d)) = 0.
    if (state_.response.size() == 0) state_.response.reset(local_), response_rhs_.reset(own_);
    const std::ptrdiff_t s = state_.p.stride(d);
    const FaceComponent<FineGrid>& g = conductance_[d];  // the pressure solver has filled its halo
    double total_volume = 1;
    for (int a = 0; a < 3; ++a) total_volume *= grid_.axis[a].length();
    double largest = 0;
    for_each(own_, [&](int i, int j, int k) {
      const std::ptrdiff_t m = state_.p.index(i, j, k);
      const Int3 x{i, j, k};
      largest = std::max(largest, g.data()[m] * momentum_.axis(d).face_width(x[d]));
      response_rhs_(i, j, k) = -(g.data()[m + s] * momentum_.axis(d).face_width(x[d] + 1) -
                                 g.data()[m] * momentum_.axis(d).face_width(x[d]));
    });
    // Where the conductance is uniform, what stands on the right is rounding alone.
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
    const double cells = double(grid_.n()[0]) * grid_.n()[1] * grid_.n()[2];
    const double target = std::max(pressure_solver_->rtol(), 4e-15) * largest * std::sqrt(cells);
    pressure_solver_->solve(response_rhs_, state_.response, target);
    fill(state_.response);
    boundaries_.apply_correction(state_.response);
    // Mean flux now, and its answer to a unit gradient.
    std::array<double, 2> mean{0, 0};
    for_each(faces_[d], [&](int i, int j, int k) {
      const std::ptrdiff_t m = state_.p.index(i, j, k);
      const Int3 x{i, j, k};
      const double w = momentum_.axis(d).face_width(x[d]), A = grid_.area(d, i, j, k);
      const double answer =
          g.data()[m] * (w + state_.response.data()[m] - state_.response.data()[m - s]);  // m3/s per Pa/m
      mean[0] += state_.eps_f[d].data()[m] * u_next_[d].data()[m] * A * w;
      mean[1] += answer * w;
    });
    MPI_Allreduce(MPI_IN_PLACE, mean.data(), 2, MPI_DOUBLE, MPI_SUM, comm_);
    const double wanted = settings_.flow_rate[d] - exchange.particle_flux[d];
    const double change = (mean[0] / total_volume - wanted) / (mean[1] / total_volume);
    state_.imposed[d] += change;
    for (int c = 0; c < 3; ++c) {
      const std::ptrdiff_t sc = state_.p.stride(c);
      for_each(faces_[c], [&](int i, int j, int k) {
        const std::ptrdiff_t m = state_.p.index(i, j, k);
        const Int3 x{i, j, k};
        const double drop = state_.response.data()[m] - state_.response.data()[m - sc] +
                            (c == d ? momentum_.axis(d).face_width(x[d]) : 0.0);
        u_next_[c].data()[m] -=
            change * conductance_[c].data()[m] / (state_.eps_f[c].data()[m] * grid_.area(c, i, j, k)) * drop;
      });
    }
    for_each(own_, [&](int i, int j, int k) { state_.phi(i, j, k) += change * state_.response(i, j, k); });
    fill(u_next_);
  }
}

template <int d>
inline void FluidSolver::add_gradient(double share) {
  const std::ptrdiff_t s = state_.p.stride(d);
  const int n = faces_[d].size(0);
  const double imposed = state_.imposed[d];
  for_each_row(faces_[d], state_.p, [&](const Int3& x, std::ptrdiff_t m) {
    const RowMeasure<d> row(momentum_, x);
    const double* p = state_.p.data() + m;
    double* __restrict g = state_.mean_grad_p[d].data() + state_.mean_grad_p[d].index(x[0], x[1], x[2]);
    for (int i = 0; i < n; ++i) g[i] += share * ((p[i] - p[i - s]) * row.inverse_width[i] + imposed);
  });
}

/// The new state's share in the interval's means.
TWOGRID_VECTORISED void FluidSolver::add_to_means(double share) {
  if (!state_.one_step)
    for (int d = 0; d < 3; ++d) {
      const int n = state_.mean_u[d].box().size(0);
      for_each_row(state_.mean_u[d].box(), state_.mean_u[d], [&](const Int3& x, std::ptrdiff_t m) {
        const double* u = state_.u[d].data() + state_.u[d].index(x[0], x[1], x[2]);
        double* __restrict mean = state_.mean_u[d].data() + m;
        for (int i = 0; i < n; ++i) mean[i] += share * u[i];
      });
    }
  if (!keep_grad_p_) return;
  if (boundaries_.component_solved(0)) add_gradient<0>(share);
  if (boundaries_.component_solved(1)) add_gradient<1>(share);
  if (boundaries_.component_solved(2)) add_gradient<2>(share);
}

void FluidSolver::accept(const Step& step, double interval) {
  for_each(own_, [&](int i, int j, int k) { state_.p(i, j, k) += state_.phi(i, j, k); });
  for (int d = 0; d < 3; ++d) {
    if (central()) state_.u_older[d].swap(state_.u_old[d]);
    state_.u_old[d].swap(state_.u[d]), state_.u[d].swap(u_next_[d]);
  }
  fill(state_.p);
  boundaries_.apply_pressure(state_.p);
  const double share = step.dt / interval;
  state_.one_step = share == 1;
  if (!state_.one_step && state_.mean_u[0].size() == 0) reset(state_.mean_u, faces_around(own_, boundaries_.halo()));
  add_to_means(share);
  state_.time += step.dt;
  state_.dt_older = state_.dt_previous;
  state_.dt_previous = step.dt;
}

/// worst: largest |d(eps)/dt - q + div(eps u)| h; displaced: -integral of d(eps)/dt - q.
TWOGRID_VECTORISED void FluidSolver::largest_imbalance(double& worst, double& displaced) const {
  const FluidState::Rate rate = state_.rate;
  const std::ptrdiff_t sy = state_.p.stride(1), sz = state_.p.stride(2);
  const int n = own_.size(0);
  double* __restrict most = row_a_.data(), * __restrict total = row_b_.data();
  std::fill_n(most, n, 0.0), std::fill_n(total, n, 0.0);
  // h = cbrt(wx wy wz) of a cell: the factor along x is applied once, at the end.
  for_each_row(own_, state_.p, [&](const Int3& q, std::ptrdiff_t m) {
    const double* ix = &momentum_.axis(0).inverse_width_[q[0] - momentum_.axis(0).lo];
    const double wy = momentum_.axis(1).width(q[1]), wz = momentum_.axis(2).width(q[2]);
    const double iy = 1 / wy, iz = 1 / wz, area = wy * wz, h = std::cbrt(area);
    const double *ex = state_.eps_f[0].data() + m, *ey = state_.eps_f[1].data() + m, *ez = state_.eps_f[2].data() + m;
    const double *ux = state_.u[0].data() + m, *uy = state_.u[1].data() + m, *uz = state_.u[2].data() + m;
    const double *e0 = state_.eps[0].data() + m, *e1 = state_.eps[1].data() + m, *e2 = state_.eps[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double void_fraction_rate = rate.b0 * e0[i] + rate.b1 * e1[i] + rate.b2 * e2[i] - rate.excess;
      const double r = (ex[i + 1] * ux[i + 1] - ex[i] * ux[i]) * ix[i] +
                       (ey[i + sy] * uy[i + sy] - ey[i] * uy[i]) * iy + (ez[i + sz] * uz[i + sz] - ez[i] * uz[i]) * iz +
                       void_fraction_rate;
      most[i] = std::max(most[i], std::abs(r) * h);
      total[i] += void_fraction_rate * area;
    }
  });
  for (int i = 0; i < n; ++i) {
    const double w = momentum_.axis(0).width(own_.lo[0] + i);
    worst = std::max(worst, most[i] * std::cbrt(w)), displaced -= total[i] * w;
  }
}

void FluidSolver::measure(const Step& step, double share, FluidReport& report) {
  ++report.steps;
  report.dt = step.dt;
  double worst = 0;
  std::array<double, 7> sum{0, 0, 0, 0, 0, 0, 0};  // inflow, outflow, displaced, p A and A at inlets, at outlets
  largest_imbalance(worst, sum[2]);
  sum[3] = inlet_head_;
  for (int side = 0; side < 6; ++side) {
    if (!has(side, BoundaryKind::kInlet) && !has(side, BoundaryKind::kPressure)) continue;  // nothing passes a wall
    boundaries_.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      const double A = grid_.area(d, i, j, k), flow = (is_high(side) ? -1 : 1) * flux(d, i, j, k) * A;
      Int3 in{i, j, k};
      if (is_high(side)) --in[d];
      const BoundaryKind kind = boundaries_.kind(side, i, j, k);
      sum[flow > 0 ? 0 : 1] += std::abs(flow);
      if (kind == BoundaryKind::kInlet) sum[3] += state_.p(in[0], in[1], in[2]) * A, sum[4] += A;
      if (kind == BoundaryKind::kPressure) {
        Int3 out = in;
        out[d] += is_high(side) ? 1 : -1;
        sum[5] += 0.5 * (state_.p(in[0], in[1], in[2]) + state_.p(out[0], out[1], out[2])) * A, sum[6] += A;
      }
    });
  }
  Reduction::over_ranks(comm_, {&worst}, {&sum[0], &sum[1], &sum[2], &sum[3], &sum[4], &sum[5], &sum[6]});
  // Velocities no larger than what the rounding of d(eps)/dt makes of a fluid at rest are no scale for an error.
  double h = 1;
  for (const Axis& axis : grid_.axis) h *= axis.length() / axis.n();
  const double rounding = 1e-13 * std::abs(state_.rate.b0) * std::cbrt(h);
  report.divergence_error = state_.velocity_scale > rounding ? worst / state_.velocity_scale : 0;
  report.inflow = sum[0], report.outflow = sum[1], report.displaced = sum[2];
  report.pressure_drop += share * ((sum[4] > 0 ? sum[3] / sum[4] : 0) - (sum[6] > 0 ? sum[5] / sum[6] : 0));
}

Vec3 FluidSolver::total_momentum() const {
  Vec3 sum{0, 0, 0};
  for (int d = 0; d < 3; ++d)
    for_each(faces_[d], [&](int i, int j, int k) {
      if (boundaries_.state(d)(i, j, k) == FaceState::kSolved)
        sum[d] += settings_.density * state_.eps_f[d](i, j, k) * state_.u[d](i, j, k) * momentum_.volume(d, i, j, k);
    });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, comm_);
  return sum;
}

Vec3 FluidSolver::pending_momentum() const {
  Vec3 sum{0, 0, 0};
  for (int d = 0; d < 3; ++d)
    for_each(faces_[d], [&](int i, int j, int k) {
      if (boundaries_.state(d)(i, j, k) == FaceState::kSolved)
        sum[d] += 0.5 * settings_.density * momentum_.volume(d, i, j, k) *
                  (state_.eps_f[d](i, j, k) * state_.u[d](i, j, k) -
                   momentum_.face_mean(state_.eps[1], d, i, j, k) * state_.u_old[d](i, j, k));
    });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, comm_);
  return sum;
}

}  // namespace twogrid
