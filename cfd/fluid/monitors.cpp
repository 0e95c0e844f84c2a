#include "cfd/fluid/monitors.h"

#include <cmath>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/reduction.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

double Monitors::difference(const FluidState& state, const FluidState& other) const {
  double sum[4] = {0, 0, 0, 0};  // (difference of eps u)^2, (eps u)^2; difference of grad p . grad p, (grad p)^2
  for (int d = 0; d < 3; ++d)
    for_each(domain_.faces[d], [&](int i, int j, int k) {
      const double V = domain_.measures.open_volume(d, i, j, k);
      const double u = state.eps_f[d](i, j, k) * state.u[d](i, j, k), g = state.mean_grad_p[d](i, j, k);
      const double du = u - other.eps_f[d](i, j, k) * other.u[d](i, j, k), dg = g - other.mean_grad_p[d](i, j, k);
      sum[0] += V * du * du, sum[1] += V * u * u;
      sum[2] += V * dg * g, sum[3] += V * g * g;
    });
  MPI_Allreduce(MPI_IN_PLACE, sum, 4, MPI_DOUBLE, MPI_SUM, domain_.comm);
  return std::max(sum[1] > 0 ? std::sqrt(sum[0] / sum[1]) : 0.0, sum[3] > 0 ? std::abs(sum[2]) / sum[3] : 0.0);
}

/// worst: largest |d(eps)/dt - q + div(eps u)| h; displaced: -integral of d(eps)/dt - q.
TWOGRID_VECTORISED void Monitors::largest_imbalance(const FluidState& state, double& worst, double& displaced) const {
  const FluidState::Rate rate = state.rate;
  const std::ptrdiff_t sy = state.p.stride(1), sz = state.p.stride(2);
  const int whole = domain_.own.size(0);
  std::fill_n(row_a_.data(), whole, 0.0), std::fill_n(row_b_.data(), whole, 0.0);
  // h = cbrt(wx wy wz) of a cell: the factor along x is applied once, at the end.
  const OpenShares* open = domain_.measures.open();
  const auto add_row = [&](const Int3& q, std::ptrdiff_t m, int n, auto excess) {
    const int first = q[0] - domain_.own.lo[0];
    double* __restrict most = row_a_.data() + first, * __restrict total = row_b_.data() + first;
    const double* ix = &domain_.measures.axis(0).inverse_width_[q[0] - domain_.measures.axis(0).lo];
    const double wy = domain_.measures.axis(1).width(q[1]), wz = domain_.measures.axis(2).width(q[2]);
    const double iy = 1 / wy, iz = 1 / wz, area = wy * wz, h = std::cbrt(area);
    const double *ex = state.eps_f[0].data() + m, *ey = state.eps_f[1].data() + m, *ez = state.eps_f[2].data() + m;
    const double *ux = state.u[0].data() + m, *uy = state.u[1].data() + m, *uz = state.u[2].data() + m;
    const double *e0 = state.eps[0].data() + m, *e1 = state.eps[1].data() + m, *e2 = state.eps[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double void_fraction_rate = rate.b0 * e0[i] + rate.b1 * e1[i] + rate.b2 * e2[i] - excess(i);
      const double r = (ex[i + 1] * ux[i + 1] - ex[i] * ux[i]) * ix[i] +
                       (ey[i + sy] * uy[i + sy] - ey[i] * uy[i]) * iy + (ez[i + sz] * uz[i + sz] - ez[i] * uz[i]) * iz +
                       void_fraction_rate;
      most[i] = std::max(most[i], std::abs(r) * h);
      total[i] += void_fraction_rate * area;
    }
  };
  for_each_row(domain_.own, domain_.measures.open_cells(), state.p, [&](const Int3& q, std::ptrdiff_t m, int n) {
    if (domain_.blowing)
      add_row(q, m, n,
              [excess = rate.excess, theta = open->theta().data() + m,
               blown = domain_.blowing->rate().data() + m](int i) { return excess * theta[i] + blown[i]; });
    else if (open)
      add_row(q, m, n, [excess = rate.excess, theta = open->theta().data() + m](int i) { return excess * theta[i]; });
    else
      add_row(q, m, n, [excess = rate.excess](int) { return excess; });
  });
  for (int i = 0; i < whole; ++i) {
    const double w = domain_.measures.axis(0).width(domain_.own.lo[0] + i);
    worst = std::max(worst, row_a_[i] * std::cbrt(w)), displaced -= row_b_[i] * w;
  }
}

void Monitors::measure(const FluidState& state, double inlet_head, double velocity_scale, double share,
                       FluidReport& report) const {
  ++report.steps;
  report.dt = state.dt_previous;
  double worst = 0;
  std::array<double, 7> sum{0, 0, 0, 0, 0, 0, 0};  // inflow, outflow, displaced, p A and A at inlets, at outlets
  largest_imbalance(state, worst, sum[2]);
  sum[3] = inlet_head;
  if (domain_.blowing) {
    // The surface is an inlet inside the domain; what enters there is no displaced volume.
    const double in = domain_.blowing->own_flow();
    sum[0] += in, sum[2] -= in;
    domain_.blowing->add_pressure(state.p, sum[3], sum[4]);
  }
  for (int side = 0; side < 6; ++side) {
    if (!domain_.has(side, BoundaryKind::kInlet) && !domain_.has(side, BoundaryKind::kPressure))
      continue;  // nothing passes a wall
    domain_.boundaries.for_each_face(side, [&](int, int i, int j, int k) {
      const int d = direction(side);
      const double whole = domain_.measures.area(d, i, j, k), A = domain_.measures.open_area(d, i, j, k),
                   flow = (is_high(side) ? -1 : 1) * (state.eps_f[d](i, j, k) * state.u[d](i, j, k)) * whole;
      Int3 in{i, j, k};
      if (is_high(side)) --in[d];
      const BoundaryKind kind = domain_.boundaries.kind(side, i, j, k);
      sum[flow > 0 ? 0 : 1] += std::abs(flow);
      if (kind == BoundaryKind::kInlet) sum[3] += state.p(in[0], in[1], in[2]) * A, sum[4] += A;
      if (kind == BoundaryKind::kPressure) {
        Int3 out = in;
        out[d] += is_high(side) ? 1 : -1;
        sum[5] += 0.5 * (state.p(in[0], in[1], in[2]) + state.p(out[0], out[1], out[2])) * A, sum[6] += A;
      }
    });
  }
  Reduction::over_ranks(domain_.comm, {&worst}, {&sum[0], &sum[1], &sum[2], &sum[3], &sum[4], &sum[5], &sum[6]});
  // Velocities no larger than what the rounding of d(eps)/dt makes of a fluid at rest are no scale for an error.
  double h = 1;
  for (const Axis& axis : domain_.grid.axis) h *= axis.length() / axis.n();
  const double rounding = 1e-13 * std::abs(state.rate.b0) * std::cbrt(h);
  report.divergence_error = velocity_scale > rounding ? worst / velocity_scale : 0;
  report.inflow = sum[0], report.outflow = sum[1], report.displaced = sum[2];
  report.pressure_drop += share * ((sum[4] > 0 ? sum[3] / sum[4] : 0) - (sum[6] > 0 ? sum[5] / sum[6] : 0));
}

Vec3 Monitors::total_momentum(const FluidState& state) const {
  Vec3 sum{0, 0, 0};
  for (int d = 0; d < 3; ++d)
    for_each(domain_.faces[d], [&](int i, int j, int k) {
      if (domain_.boundaries.state(d)(i, j, k) == FaceState::kSolved)
        sum[d] += settings_.density * state.inertia_share()[d](i, j, k) * state.u[d](i, j, k) *
                  domain_.measures.volume(d, i, j, k);
    });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, domain_.comm);
  return sum;
}

Vec3 Monitors::pending_momentum(const FluidState& state) const {
  Vec3 sum{0, 0, 0};
  for (int d = 0; d < 3; ++d)
    for_each(domain_.faces[d], [&](int i, int j, int k) {
      if (domain_.boundaries.state(d)(i, j, k) == FaceState::kSolved)
        sum[d] += 0.5 * settings_.density * domain_.measures.volume(d, i, j, k) *
                  (state.inertia_share()[d](i, j, k) * state.u[d](i, j, k) -
                   domain_.measures.face_mean(state.eps[1], d, i, j, k) * state.u_old[d](i, j, k));
    });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, domain_.comm);
  return sum;
}

}  // namespace twogrid
