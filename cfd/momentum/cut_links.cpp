#include "cfd/momentum/cut_links.h"

namespace twogrid {

CutLinks::CutLinks(const GridMeasures& measures, const std::array<Box, 3>& faces, const std::array<bool, 3>& solved)
    : measures_(measures) {
  const OpenShares& open = *measures.open();
  if (!open.has_links()) return;
  const CellField<FineGrid>& theta = open.theta();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      if (!solved[c] || !solved[d] || faces[c].empty()) continue;
      const std::ptrdiff_t sd = theta.stride(d), sc = theta.stride(c);
      Box lower = faces[c];
      --lower.lo[d];
      // Along its own direction a side's face has no neighbour beyond.
      const AxisMeasure& axis = measures.axis(d);
      for_each(lower, [&](int i, int j, int k) {
        const Int3 x{i, j, k};
        const std::ptrdiff_t m = theta.index(i, j, k);
        if (c == d && !(axis.half_below(x[d] + 1) > 0 && axis.half_above(x[d]) > 0)) return;
        const bool cut = c == d ? open.cell().data()[m] == 0 : open.edge(3 - c - d).data()[m + sd] == 0;
        if (!cut || !open.linked(c, d, m)) return;
        if (!(open.alpha(c, m) > 0 && open.alpha(c, m + sd) > 0)) return;
        double around = theta.data()[m];
        if (c != d) around += theta.data()[m - sc] + theta.data()[m + sd] + theta.data()[m + sd - sc];
        const double through = aperture(c, d, m, x);
        if (through > 0) links_[c][d].push_back({m, through / around});
      });
    }
}

/// a A/h between a face and the next one above in d.
double CutLinks::aperture(int c, int d, std::ptrdiff_t lower, const Int3& x) const {
  const OpenShares& open = *measures_.open();
  const std::ptrdiff_t sc = open.theta().stride(c), sd = open.theta().stride(d);
  const auto width = [&](int e) { return measures_.axis(e).width(x[e]); };
  if (c == d)
    return 0.5 * (open.alpha(c, lower) + open.alpha(c, lower + sd)) * width((c + 1) % 3) * width((c + 2) % 3) /
           width(c);
  const AxisMeasure& along = measures_.axis(c);
  const double open_width =
      along.half_below(x[c]) * open.alpha(d, lower + sd - sc) + along.half_above(x[c]) * open.alpha(d, lower + sd);
  return open_width * width(3 - c - d) / measures_.axis(d).face_width(x[d] + 1);
}

/// f(component, lower face, upper face, mu eps a A/h).
template <class F>
inline void CutLinks::for_each_link(const Property& mu, const CellField<FineGrid>& e, F&& f) const {
  const double* held = e.data();
  const double* viscosity = mu.varies() ? mu.field().data() : nullptr;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t sd = e.stride(d), sc = e.stride(c);
      for (const Link& link : links_[c][d]) {
        const std::ptrdiff_t m = link.lower, up = m + sd;
        double eps = held[m], mu_here = viscosity ? viscosity[m] : mu.number;
        if (c != d) {
          eps += held[m - sc] + held[up] + held[up - sc];
          if (viscosity)
            mu_here = 4 / (1 / viscosity[m] + 1 / viscosity[m - sc] + 1 / viscosity[up] + 1 / viscosity[up - sc]);
        }
        f(c, m, up, mu_here * eps * link.conductance);
      }
    }
}

void CutLinks::add(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                   FaceField<FineGrid>& out) const {
  for_each_link(mu, e, [&](int c, std::ptrdiff_t lower, std::ptrdiff_t upper, double conductance) {
    const double* v = u[c].data();
    const double force = conductance * (v[upper] - v[lower]);
    out[c].data()[lower] += force;
    out[c].data()[upper] -= force;
  });
}

void CutLinks::add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) const {
  for_each_link(mu, e, [&](int c, std::ptrdiff_t lower, std::ptrdiff_t upper, double conductance) {
    diagonal[c].data()[lower] += conductance;
    diagonal[c].data()[upper] += conductance;
  });
}

}  // namespace twogrid
