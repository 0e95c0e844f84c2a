#include "cfd/fluid/interval_means.h"

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// All faces of the cells, in one box for the three directions.
Box faces_around(const Box& own, const Int3& halo) {
  Box b = own;
  for (int d = 0; d < 3 && !own.empty(); ++d) b.hi[d] += std::min(halo[d], 1);
  return b;
}

}  // namespace

void IntervalMeans::begin(FluidState& state) const {
  state.one_step = false;
  for (auto& u : state.mean_u) u.fill(0);
  if (!keep_pressure_gradient) return;
  if (state.mean_grad_p[0].size() == 0) reset(state.mean_grad_p, faces_around(domain_.own, domain_.boundaries.halo()));
  for (auto& g : state.mean_grad_p) g.fill(0);
}

template <int d>
inline void IntervalMeans::add_gradient(double share, FluidState& state) const {
  const std::ptrdiff_t s = state.p.stride(d);
  const double imposed = state.imposed[d];
  for_each_row(domain_.faces[d], nullptr, state.p, [&](const Int3& x, std::ptrdiff_t m, int n) {
    const RowMeasure<d> row(domain_.measures, x);
    const double* p = state.p.data() + m;
    double* __restrict g = state.mean_grad_p[d].data() + state.mean_grad_p[d].index(x[0], x[1], x[2]);
    for (int i = 0; i < n; ++i) g[i] += share * ((p[i] - p[i - s]) * row.inverse_width[i] + imposed);
  });
}

/// The new state's share in the interval's means.
TWOGRID_VECTORISED void IntervalMeans::add_rows(double share, FluidState& state) const {
  if (!state.one_step)
    for (int d = 0; d < 3; ++d) {
      for_each_row(state.mean_u[d].box(), nullptr, state.mean_u[d], [&](const Int3& x, std::ptrdiff_t m, int n) {
        const double* u = state.u[d].data() + state.u[d].index(x[0], x[1], x[2]);
        double* __restrict mean = state.mean_u[d].data() + m;
        for (int i = 0; i < n; ++i) mean[i] += share * u[i];
      });
    }
  if (!keep_pressure_gradient) return;
  if (domain_.solved[0]) add_gradient<0>(share, state);
  if (domain_.solved[1]) add_gradient<1>(share, state);
  if (domain_.solved[2]) add_gradient<2>(share, state);
}

void IntervalMeans::add(double share, FluidState& state) const {
  state.one_step = share == 1;
  if (!state.one_step && state.mean_u[0].size() == 0)
    reset(state.mean_u, faces_around(domain_.own, domain_.boundaries.halo()));
  add_rows(share, state);
}

}  // namespace twogrid
