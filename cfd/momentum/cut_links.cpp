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
  for (int c = 0; c < 3; ++c)
    if (solved[c]) list_transposed(c, faces[c], solved);
}

void CutLinks::list_transposed(int c, const Box& faces, const std::array<bool, 3>& solved) {
  const OpenShares& open = *measures_.open();
  const CellField<FineGrid>& theta = open.theta();
  const std::ptrdiff_t sc = theta.stride(c);
  for_each(faces, [&](int i, int j, int k) {
    const Int3 x{i, j, k};
    const std::ptrdiff_t m = theta.index(i, j, k);
    if (!(open.alpha(c, m) > 0) || open.sliver(c, m)) return;
    const auto width = [&](int d) { return measures_.axis(d).width(x[d]); };
    const double below = measures_.axis(c).half_below(x[c]), above = measures_.axis(c).half_above(x[c]);
    const int slot = int(faces_[c].size());
    std::array<std::vector<Transposed>, 3> uncut;
    bool cut = false;
    for (bool up : {false, true}) {
      const double sign = up ? 1 : -1;
      for (int d = 0; d < 3; ++d) {
        if (!solved[d]) continue;
        if (d == c) {
          if (!((up ? above : below) > 0)) continue;
          const std::ptrdiff_t at = up ? m : m - sc;
          cut = cut || open.cell().data()[at] == 0;
          Vec3 inverse;
          for (int e = 0; e < 3; ++e)
            inverse[e] = solved[e] ? 1 / measures_.axis(e).width(x[e] - (e == c && !up)) : 0.0;
          const double area = width((c + 1) % 3) * width((c + 2) % 3);
          if (open.cell().data()[at] != 0) uncut[d].push_back({slot, at, sign * area / theta.data()[at], inverse});
        } else {
          const std::ptrdiff_t at = up ? m + theta.stride(d) : m, sd = theta.stride(d);
          const CellField<FineGrid>& edge = open.edge(3 - c - d);
          cut = cut || edge.data()[at] == 0;
          const double around =
              theta.data()[at] + theta.data()[at - sc] + theta.data()[at - sd] + theta.data()[at - sc - sd];
          const double area = (below + above) * width(3 - c - d);
          if (edge.data()[at] != 0)
            uncut[d].push_back({slot, at, sign * area / measures_.axis(c).face_width(x[c]) / around, {0, 0, 0}});
        }
      }
    }
    if (!cut) return;
    faces_[c].push_back(m);
    for (int d = 0; d < 3; ++d) transposed_[c][d].insert(transposed_[c][d].end(), uncut[d].begin(), uncut[d].end());
  });
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

/// f(component, slot, force of the transposed gradients on one side).
template <class F>
inline void CutLinks::for_each_transposed(const Property& mu, const CellField<FineGrid>& e,
                                          const FaceField<FineGrid>& u, F&& f) const {
  const double* held = e.data();
  const double* viscosity = mu.varies() ? mu.field().data() : nullptr;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t sd = e.stride(d), sc = e.stride(c);
      for (const Transposed& t : transposed_[c][d]) {
        const std::ptrdiff_t m = t.at;
        double eps = held[m], mu_here = viscosity ? viscosity[m] : mu.number, slope;
        if (c != d) {
          eps += held[m - sc] + held[m - sd] + held[m - sc - sd];
          if (viscosity)
            mu_here =
                4 / (1 / viscosity[m] + 1 / viscosity[m - sc] + 1 / viscosity[m - sd] + 1 / viscosity[m - sc - sd]);
          slope = u[d].data()[m] - u[d].data()[m - sc];
        } else {
          double divergence = 0;
          for (int q = 0; q < 3; ++q) divergence += (u[q].data()[m + e.stride(q)] - u[q].data()[m]) * t.inverse[q];
          slope = (u[c].data()[m + sc] - u[c].data()[m]) * t.inverse[c] - 2.0 / 3 * divergence;
        }
        f(c, t.slot, mu_here * eps * t.factor * slope);
      }
    }
}

void CutLinks::left_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                        std::array<std::vector<double>, 3>& force) const {
  for (int c = 0; c < 3; ++c) force[c].assign(faces_[c].size(), 0.0);
  for_each_transposed(mu, e, u, [&](int c, int slot, double f) { force[c][slot] += f; });
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
  for_each_transposed(mu, e, u, [&](int c, int slot, double f) { out[c].data()[faces_[c][slot]] -= f; });
}

void CutLinks::add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) const {
  for_each_link(mu, e, [&](int c, std::ptrdiff_t lower, std::ptrdiff_t upper, double conductance) {
    diagonal[c].data()[lower] += conductance;
    diagonal[c].data()[upper] += conductance;
  });
}

}  // namespace twogrid
