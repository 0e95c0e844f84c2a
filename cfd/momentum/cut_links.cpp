#include "cfd/momentum/cut_links.h"

namespace twogrid {

namespace {

/// Mean over the cells around the edge at the low corner of cell m, by volume; so, s: strides, and the upper cells' shares.
template <class F>
inline double mean_around(std::ptrdiff_t m, std::ptrdiff_t so, double own, std::ptrdiff_t s, double other, F&& f) {
  const double low = (1 - own) * f(m - so - s) + own * f(m - s), high = (1 - own) * f(m - so) + own * f(m);
  return (1 - other) * low + other * high;
}

}  // namespace

CutLinks::CutLinks(const GridMeasures& measures, const std::array<Box, 3>& faces, const std::array<bool, 3>& solved)
    : measures_(measures) {
  const OpenShares& open = *measures.open();
  if (!open.has_links()) return;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      if (!solved[c] || !solved[d] || faces[c].empty()) continue;
      const std::ptrdiff_t sd = open.theta().stride(d);
      Box lower = faces[c];
      --lower.lo[d];
      for_each(lower, [&](int i, int j, int k) {
        const std::ptrdiff_t m = open.theta().index(i, j, k);
        const bool cut = c == d ? open.cell().data()[m] == 0 : open.edge(3 - c - d).data()[m + sd] == 0;
        Link link;
        if (cut && link_above(c, d, {i, j, k}, link)) links_[c][d].push_back(link);
      });
    }
  for (int c = 0; c < 3; ++c)
    if (solved[c]) list_transposed(c, faces[c], solved);
}

/// Between a face and the next one above in d, if nothing parts them.
bool CutLinks::link_above(int c, int d, const Int3& x, Link& link) const {
  const OpenShares& open = *measures_.open();
  const double* theta = open.theta().data();
  const std::ptrdiff_t m = open.theta().index(x[0], x[1], x[2]), sd = open.theta().stride(d),
                       sc = open.theta().stride(c);
  // Along its own direction a side's face has no neighbour beyond.
  const AxisMeasure& axis = measures_.axis(d);
  if (c == d && !(axis.half_below(x[d] + 1) > 0 && axis.half_above(x[d]) > 0)) return false;
  if (!open.linked(c, d, m) || !(open.alpha(c, m) > 0 && open.alpha(c, m + sd) > 0)) return false;
  const double through = aperture(c, d, m, x);
  if (!(through > 0)) return false;
  Int3 edge = x;
  ++edge[d];
  link = {m, through / theta[m], {0, 0}, {open.centre(c, m), open.centre(c, m + sd)}};
  if (c == d) return true;
  link.around = around(c, d, edge);
  link.conductance = through / mean_around(m + sd, sc, link.around.own, sd, link.around.other,
                                           [theta](std::ptrdiff_t q) { return theta[q]; });
  return true;
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
          if (open.cell().data()[at] != 0)
            uncut[d].push_back({slot, at, sign * area / theta.data()[at], inverse, {0, 0}});
        } else {
          const std::ptrdiff_t at = up ? m + theta.stride(d) : m;
          const CellField<FineGrid>& edge = open.edge(3 - c - d);
          cut = cut || edge.data()[at] == 0;
          const double area = (below + above) * width(3 - c - d);
          Int3 low = x;
          low[d] += up;
          // The factor of the edge is 1 over the mean of theta around it.
          if (edge.data()[at] != 0)
            uncut[d].push_back({slot,
                                at,
                                sign * area / measures_.axis(c).face_width(x[c]) * edge.data()[at],
                                {0, 0, 0},
                                around(c, d, low)});
        }
      }
    }
    if (!cut) return;
    faces_[c].push_back(m);
    const double more = open.viscous(c, m) - 1;
    for (int d = 0; d < 3 && more != 0; ++d)
      for (bool up : {false, true}) {
        Int3 lower = x;
        if (!up) --lower[d];
        Steeper s{slot, up, {}};
        if (!solved[d] || !link_above(c, d, lower, s.link)) continue;
        s.link.conductance *= more;
        steeper_[c][d].push_back(s);
      }
    for (int d = 0; d < 3; ++d) transposed_[c][d].insert(transposed_[c][d].end(), uncut[d].begin(), uncut[d].end());
  });
}

CutLinks::Around CutLinks::around(int c, int d, const Int3& edge) const {
  const AxisMeasure &own = measures_.axis(c), &other = measures_.axis(d);
  return {own.above_share_[edge[c] - own.lo], other.above_share_[edge[d] - other.lo]};
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
          const auto mean = [&](auto&& of) { return mean_around(m, sc, t.around.own, sd, t.around.other, of); };
          eps = mean([held](std::ptrdiff_t q) { return held[q]; });
          if (viscosity) mu_here = 1 / mean([viscosity](std::ptrdiff_t q) { return 1 / viscosity[q]; });
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
                        std::array<std::vector<double>, 3>& force,
                        std::array<std::vector<double>, 3>& exceeding) const {
  for (int c = 0; c < 3; ++c) force[c].assign(faces_[c].size(), 0.0), exceeding[c].assign(faces_[c].size(), 0.0);
  for_each_transposed(mu, e, u, [&](int c, int slot, double f) { force[c][slot] += f; });
  for_each_steeper(mu, e, u, [&](int c, int slot, double f) { force[c][slot] -= f, exceeding[c][slot] -= f; });
}

/// mu eps a A/h; mu: harmonic mean of what is open around.
inline double CutLinks::conductance(const Link& link, bool along, std::ptrdiff_t sc, std::ptrdiff_t sd,
                                    const Property& mu, const double* held, const double* theta) const {
  const double* viscosity = mu.varies() ? mu.field().data() : nullptr;
  const std::ptrdiff_t m = link.lower, up = m + sd;
  if (along) return (viscosity ? viscosity[m] : mu.number) * held[m] * link.conductance;
  const auto mean = [&](auto&& of) { return mean_around(up, sc, link.around.own, sd, link.around.other, of); };
  const double eps = mean([held](std::ptrdiff_t q) { return held[q]; });
  if (!viscosity) return mu.number * eps * link.conductance;
  return mean([theta](std::ptrdiff_t q) { return theta[q]; }) /
         mean([theta, viscosity](std::ptrdiff_t q) { return theta[q] / viscosity[q]; }) * eps * link.conductance;
}

/// f(component, slot, force on the face of the slot that it has more than its neighbours give).
template <class F>
inline void CutLinks::for_each_steeper(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                                       F&& f) const {
  const double* theta = measures_.open()->theta().data();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t sd = e.stride(d), sc = e.stride(c);
      const double* v = u[c].data();
      for (const Steeper& s : steeper_[c][d]) {
        const double change = s.link.centre[1] * v[s.link.lower + sd] - s.link.centre[0] * v[s.link.lower];
        f(c, s.slot, (s.up ? change : -change) * conductance(s.link, c == d, sc, sd, mu, e.data(), theta));
      }
    }
}

/// f(component, link, upper face, mu eps a A/h).
template <class F>
inline void CutLinks::for_each_link(const Property& mu, const CellField<FineGrid>& e, F&& f) const {
  const double* theta = measures_.open()->theta().data();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t sd = e.stride(d), sc = e.stride(c);
      for (const Link& link : links_[c][d])
        f(c, link, link.lower + sd, conductance(link, c == d, sc, sd, mu, e.data(), theta));
    }
}

void CutLinks::add(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                   FaceField<FineGrid>& out) const {
  for_each_link(mu, e, [&](int c, const Link& link, std::ptrdiff_t upper, double conductance) {
    const double* v = u[c].data();
    const double force = conductance * (link.centre[1] * v[upper] - link.centre[0] * v[link.lower]);
    out[c].data()[link.lower] += force;
    out[c].data()[upper] -= force;
  });
  for_each_transposed(mu, e, u, [&](int c, int slot, double f) { out[c].data()[faces_[c][slot]] -= f; });
  for_each_steeper(mu, e, u, [&](int c, int slot, double f) { out[c].data()[faces_[c][slot]] += f; });
}

void CutLinks::add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) const {
  for_each_link(mu, e, [&](int c, const Link& link, std::ptrdiff_t upper, double conductance) {
    diagonal[c].data()[link.lower] += link.centre[0] * conductance;
    diagonal[c].data()[upper] += link.centre[1] * conductance;
  });
  const double* theta = measures_.open()->theta().data();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (const Steeper& s : steeper_[c][d])
        diagonal[c].data()[faces_[c][s.slot]] +=
            s.link.centre[s.up ? 0 : 1] * conductance(s.link, c == d, e.stride(c), e.stride(d), mu, e.data(), theta);
}

}  // namespace twogrid
