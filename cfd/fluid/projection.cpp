#include "cfd/fluid/projection.h"

#include <cmath>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/reduction.h"
#include "cfd/parallel/vectorised.h"
#include "cfd/pressure/pressure_solver.h"

namespace twogrid {

Projection::Projection(FluidDomain& domain, const FluidSettings& settings)
    : domain_(domain),
      pressure_solver_(std::make_unique<PressureSolver>(domain.comm, domain.grid, domain.layout, settings.pressure_rtol,
                                                        domain.boundaries.halo(), domain.measures.open_cells())),
      density_(settings.density),
      imbalance_(domain.own),
      row_a_(domain.local.size(0)),
      row_b_(domain.local.size(0)) {}

Projection::~Projection() = default;

template <int d>
inline void Projection::conductance_component(const FluidState& state, const Inertia& inertia,
                                              const Interphase& exchange, FaceField<FineGrid>& conductance) {
  double* __restrict A = row_a_.data();
  const FaceComponent<FineGrid>& inertia_share = state.inertia_share()[d];
  const OpenShares* open = domain_.measures.open();
  for_each_row(domain_.faces[d], domain_.measures.open_faces(d), state.p, [&](const Int3& x, std::ptrdiff_t m, int n) {
    const RowMeasure<d> row(domain_.measures, x);
    const double *e = state.eps_f[d].data() + m, *share = inertia_share.data() + m;
    double* __restrict g = conductance[d].data() + m;
    inertia.row(d, m, share, exchange.beta_row(d, x[0], x[1], x[2], n, row_b_.data()), n, A);
    if (open) {
      const double* theta = open->theta_f()[d].data() + m;  // 0: closed
#pragma GCC ivdep
      for (int i = 0; i < n; ++i) g[i] = e[i] / A[i] * row.area(i) * row.inverse_width[i] * theta[i];
    } else {
      for (int i = 0; i < n; ++i) g[i] = e[i] / A[i] * row.area(i) * row.inverse_width[i];
    }
  });
}

TWOGRID_VECTORISED void Projection::conductance_rows(const FluidState& state, const Inertia& inertia,
                                                     const Interphase& exchange, FaceField<FineGrid>& conductance) {
  for (int d = 0; d < 3; ++d)
    if (!domain_.solved[d]) conductance[d].fill(0);
  if (domain_.solved[0]) conductance_component<0>(state, inertia, exchange, conductance);
  if (domain_.solved[1]) conductance_component<1>(state, inertia, exchange, conductance);
  if (domain_.solved[2]) conductance_component<2>(state, inertia, exchange, conductance);
}

/// Conductance of faces: eps/A times area over the distance of the centres (with open shares phi theta_f/A times the
/// whole area); half of the distance at an outlet, none through prescribed faces.
void Projection::set_conductance(const FluidState& state, const Inertia& inertia, const Interphase& exchange,
                                 FaceField<FineGrid>& conductance) {
  conductance_rows(state, inertia, exchange, conductance);
  for (int side = 0; side < 6; ++side)
    domain_.boundaries.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      conductance[d](i, j, k) *= domain_.boundaries.state(d)(i, j, k) == FaceState::kFixed ? 0 : 2;
    });
}

/// imbalance_: what is missing in continuity, sum of eps u* A + (d(eps)/dt - q) V, and its sum; scale: the largest
/// |eps u*|.
TWOGRID_VECTORISED void Projection::missing_continuity(const FluidState& state, const FaceField<FineGrid>& u_next,
                                                       double& scale, double& sum) {
  const FluidState::Rate rate = state.rate;
  const std::ptrdiff_t sy = state.p.stride(1), sz = state.p.stride(2);
  const int whole = domain_.own.size(0);
  std::fill_n(row_a_.data(), whole, 0.0), std::fill_n(row_b_.data(), whole, 0.0);
  for_each_row(domain_.own, domain_.measures.open_cells(), state.p, [&](const Int3& q, std::ptrdiff_t m, int n) {
    const int first = q[0] - domain_.own.lo[0];
    double* __restrict most = row_a_.data() + first, * __restrict total = row_b_.data() + first;
    const CellRowMeasure row(domain_.measures, q);
    double* __restrict b = imbalance_.data() + imbalance_.index(q[0], q[1], q[2]);
    const double *ex = state.eps_f[0].data() + m, *ey = state.eps_f[1].data() + m, *ez = state.eps_f[2].data() + m;
    const double *ux = u_next[0].data() + m, *uy = u_next[1].data() + m, *uz = u_next[2].data() + m;
    const double *e0 = state.eps[0].data() + m, *e1 = state.eps[1].data() + m, *e2 = state.eps[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x0 = ex[i] * ux[i], x1 = ex[i + 1] * ux[i + 1];
      const double y0 = ey[i] * uy[i], y1 = ey[i + sy] * uy[i + sy];
      const double z0 = ez[i] * uz[i], z1 = ez[i + sz] * uz[i + sz];
      const double void_fraction_rate = rate.b0 * e0[i] + rate.b1 * e1[i] + rate.b2 * e2[i];
      b[i] = (x1 - x0) * row.area_x(i) + (y1 - y0) * row.area_y(i) + (z1 - z0) * row.area_z(i) +
             void_fraction_rate * row.volume(i);
      total[i] += b[i];
      const double x = std::max(std::abs(x0), std::abs(x1)), y = std::max(std::abs(y0), std::abs(y1)),
                   z = std::max(std::abs(z0), std::abs(z1));
      most[i] = std::max(most[i], std::max(x, std::max(y, z)));
    }
  });
  for (int i = 0; i < whole; ++i) scale = std::max(scale, row_a_[i]), sum += row_b_[i];
}

int Projection::project(FluidState& state, const Step& step, const Inertia& inertia, const Interphase& exchange,
                        FaceField<FineGrid>& u_next, FaceField<FineGrid>& conductance) {
  domain_.face_halo.bring(u_next);
  domain_.boundaries.apply_normal(u_next);

  set_conductance(state, inertia, exchange, conductance);
  double scale = 0, sum = 0;
  state.rate = {step.a0 / step.dt, step.a1 / step.dt, step.a2 / step.dt, 0};
  missing_continuity(state, u_next, scale, sum);
  if (domain_.blowing) domain_.blowing->take_off(imbalance_, sum, scale);
  const double total_volume = domain_.volume();
  double whole = sum;
  Reduction::over_ranks(domain_.comm, {&scale}, {&whole});
  velocity_scale_ = scale;
  if (!domain_.boundaries.open()) {
    // A closed or periodic domain: what is left over is the round-off of the solid volume's conservation.
    state.rate.excess = whole / total_volume;
    for_each(domain_.own, [&](int i, int j, int k) {
      imbalance_(i, j, k) -=
          state.rate.excess * (domain_.measures.cell_volume(i, j, k) * domain_.measures.open_share(i, j, k));
    });
  }
  if (step.implicit_viscosity) divergence_ = imbalance_;
  const double cells = domain_.cells();
  const double cell_volume = total_volume / cells, h = std::cbrt(cell_volume);
  // Of a cube of fluid without particles. By the step alone, so that it is no state.
  pressure_solver_->set_typical_conductance(step.dt / (step.a0 * density_) * h);
  pressure_solver_->set_operator(conductance, !domain_.boundaries.open());
  // Continuity error wanted: |r| h/(U V) <= rtol in the root mean square over cells.
  // Not below what rounding leaves of the flows and of the differences of eps.
  const double rounding = 4e-16 * (6 * scale / h + step.a0 / step.dt);
  const double atol = std::max(pressure_solver_->rtol() * scale / h, rounding) * cell_volume * std::sqrt(cells);
  // First guess: the pressure goes on changing as in the last step.
  for (std::size_t m = 0; m < state.phi.size(); ++m) state.phi.data()[m] *= step.r;
  const int iterations = pressure_solver_->solve(imbalance_, state.phi, atol);
  if (domain_.boundaries.open())
    balance_outlets(sum, conductance, state.phi);
  else if (domain_.measures.open())
    centre_open_cells(state.phi);
  return iterations;
}

/// Continuity of the whole domain, of which the solver has left a part of its tolerance: phi is raised by what makes
/// the outlets let out the rest. No other face feels it. sum: the rank's own imbalance before the solve (m3/s).
/// Collective.
void Projection::balance_outlets(double sum, const FaceField<FineGrid>& conductance, CellField<FineGrid>& phi) const {
  double flow[3] = {sum, 0, 0};  // m3/s: missing; let out by phi; by one of 1 Pa
  for (int side = 0; side < 6; ++side)
    domain_.boundaries.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      const double g = conductance[d](i, j, k);
      const std::ptrdiff_t cell = phi.index(i, j, k) - (side % 2 == 1 ? phi.stride(d) : 0);
      flow[1] += g * phi.data()[cell];
      flow[2] += g;
    });
  MPI_Allreduce(MPI_IN_PLACE, flow, 3, MPI_DOUBLE, MPI_SUM, domain_.comm);
  if (!(flow[2] > 0)) return;
  const double rise = -(flow[0] + flow[1]) / flow[2];
  for_each(domain_.own, [&](int i, int j, int k) { phi(i, j, k) += rise; });
}

/// A closed domain's phi, whose mean is free: zero over the open cells, and zero in closed ones. Collective.
void Projection::centre_open_cells(CellField<FineGrid>& phi) const {
  double sum = 0;
  for_each(domain_.own, [&](int i, int j, int k) {
    sum += phi(i, j, k) * (domain_.measures.cell_volume(i, j, k) * domain_.measures.open_share(i, j, k));
  });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, domain_.comm);
  const double mean = sum / domain_.volume();
  for_each(domain_.own, [&](int i, int j, int k) {
    double& f = phi(i, j, k);
    f = domain_.measures.open_share(i, j, k) > 0 ? f - mean : 0.0;
  });
}

/// u^{n+1} = u* - grad phi/A, with 1/A from the conductance, g = eps/A area/distance. eps is that of the flux, and not
/// zero at closed faces either (measures/open_shares.h).
template <int d>
inline void Projection::correct_component(const FluidState& state, const FaceField<FineGrid>& conductance,
                                          FaceField<FineGrid>& u_next) const {
  const std::ptrdiff_t s = state.p.stride(d);
  for_each_row(domain_.faces[d], domain_.measures.open_faces(d), state.p, [&](const Int3& x, std::ptrdiff_t m, int n) {
    const RowMeasure<d> row(domain_.measures, x);
    const double *g = conductance[d].data() + m, *e = state.eps_f[d].data() + m, *f = state.phi.data() + m;
    double* __restrict u = u_next[d].data() + m;
    for (int i = 0; i < n; ++i) u[i] -= g[i] / (e[i] * row.area(i)) * (f[i] - f[i - s]);
  });
}

TWOGRID_VECTORISED void Projection::correct_rows(const FluidState& state, const FaceField<FineGrid>& conductance,
                                                 FaceField<FineGrid>& u_next) const {
  if (domain_.solved[0]) correct_component<0>(state, conductance, u_next);
  if (domain_.solved[1]) correct_component<1>(state, conductance, u_next);
  if (domain_.solved[2]) correct_component<2>(state, conductance, u_next);
}

void Projection::correct(FluidState& state, const FaceField<FineGrid>& conductance, FaceField<FineGrid>& u_next) const {
  domain_.fill(state.phi);
  // An outlet's conductance is that of half the distance: its ghost is zero at the face itself.
  domain_.boundaries.apply_correction(state.phi);
  correct_rows(state, conductance, u_next);
  domain_.fill(u_next);
}

void Projection::rotate_pressure(const Property& mu, FluidState& state) const {
  const auto lower = [&](const auto& mu_of) {
    for_each(domain_.own, [&](int i, int j, int k) {
      state.p(i, j, k) -= 4.0 / 3.0 * mu_of(i, j, k) * divergence_(i, j, k) / domain_.measures.cell_volume(i, j, k);
    });
  };
  if (mu.varies())
    lower(mu.field());
  else
    lower([number = mu.number](int, int, int) { return number; });
  domain_.fill(state.p);
  domain_.boundaries.apply_pressure(state.p);
}

}  // namespace twogrid
