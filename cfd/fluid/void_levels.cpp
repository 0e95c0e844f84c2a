#include "cfd/fluid/void_levels.h"

#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// From memory index `first` of the path's fields on.
TWOGRID_VECTORISED void void_fraction_at(const VoidFractionInTime& eps, double s, double interval, std::ptrdiff_t first,
                                         std::size_t n, double* __restrict out) {
  const VoidFractionInTime path = eps;
  for (std::size_t m = 0; m < n; ++m) out[m] = path.at(first + std::ptrdiff_t(m), s, interval);
}

TWOGRID_VECTORISED void multiply(std::size_t n, const double* share, double* __restrict values) {
  for (std::size_t m = 0; m < n; ++m) values[m] *= share[m];
}

/// The same, after the values have been copied to `whole`.
TWOGRID_VECTORISED void multiply(std::size_t n, const double* share, double* __restrict values,
                                 double* __restrict whole) {
#pragma GCC ivdep
  for (std::size_t m = 0; m < n; ++m) {
    const double value = values[m];
    whole[m] = value, values[m] = value * share[m];
  }
}

}  // namespace

void set_face_eps(const FluidDomain& domain, FluidState& state) {
  const OpenShares* open = domain.measures.open();
  FaceField<FineGrid>& i_f = open ? state.i_f : state.eps_f;
  domain.measures.face_mean(state.eps[0], i_f);
  domain.boundaries.apply_face_eps(i_f);
  domain.face_halo.bring(i_f);
  if (open) open->flux_share(i_f, state.eps_f);
}

void take_open_part(const FluidDomain& domain, CellField<FineGrid>& eps, CellField<FineGrid>* whole) {
  const OpenShares* open = domain.measures.open();
  if (!open) return;
  if (whole && !(whole->box() == eps.box())) whole->reset(eps.box());
  if (whole)
    multiply(eps.size(), open->theta().data(), eps.data(), whole->data());
  else
    multiply(eps.size(), open->theta().data(), eps.data());
}

void next_level(const FluidDomain& domain, const VoidFractionInTime& eps, double s, double interval,
                FluidState& state) {
  std::swap(state.eps[1], state.eps[2]);
  std::swap(state.eps[0], state.eps[1]);
  if (eps.begin->box() == domain.local)
    void_fraction_at(eps, s, interval, 0, state.eps[0].size(), state.eps[0].data());
  else
    for (int k = domain.local.lo[2]; k < domain.local.hi[2]; ++k)
      for (int j = domain.local.lo[1]; j < domain.local.hi[1]; ++j)
        void_fraction_at(eps, s, interval, eps.begin->index(domain.local.lo[0], j, k), domain.local.size(0),
                         state.eps[0].data() + state.eps[0].index(domain.local.lo[0], j, k));
  take_open_part(domain, state.eps[0], &state.eps_open);
  set_face_eps(domain, state);
}

void replace_fluid(const FluidDomain& domain, const CellField<FineGrid>& now, bool same_flux, FluidState& state) {
  const auto by_eps = [&](bool times) {
    for (int d = 0; d < 3; ++d)
      for_each(domain.faces[d], [&](int i, int j, int k) {
        const double now = state.inertia_share()[d](i, j, k),
                     before = domain.measures.face_mean(state.eps[1], d, i, j, k);
        if (!(before > 0)) return;  // between closed cells
        state.u[d](i, j, k) *= times ? now : 1 / now;
        state.u_old[d](i, j, k) *= times ? before : 1 / before;
      });
  };
  if (same_flux) by_eps(true);
  for_each(domain.local, [&](int i, int j, int k) {
    const std::ptrdiff_t m = state.p.index(i, j, k);
    double &e0 = state.eps[0].data()[m], &e1 = state.eps[1].data()[m];
    const double eps = now(i, j, k) * domain.measures.open_share(i, j, k), change = eps - e0;
    e0 = eps;
    e1 = std::max(e1 + change, 0.5 * std::min(e1, e0));
  });
  if (state.eps_open.size() > 0)
    for_each(domain.local, [&](int i, int j, int k) { state.eps_open(i, j, k) = now(i, j, k); });
  set_face_eps(domain, state);
  if (!same_flux) return;
  by_eps(false);
  domain.boundaries.apply_normal(state.u);
  domain.fill(state.u);
  domain.fill(state.u_old);
  state.dt_older = 0;  // u^{n-2} is not carried over
}

void previous_level(FluidState& state) {
  std::swap(state.eps[0], state.eps[1]);
  std::swap(state.eps[1], state.eps[2]);
}

}  // namespace twogrid
