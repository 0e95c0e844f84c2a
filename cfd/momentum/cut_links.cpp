#include "cfd/momentum/cut_links.h"

#include <algorithm>

#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// Mean over the cells around an edge, by volume; its memory index, strides and shares of the upper cells in the two
/// directions normal to it.
template <class F>
inline double mean_around(std::ptrdiff_t m, std::ptrdiff_t sa, double a, std::ptrdiff_t sb, double b, F&& f) {
  const double low = (1 - a) * f(m - sa - sb) + a * f(m - sb), high = (1 - a) * f(m - sa) + a * f(m);
  return (1 - b) * low + b * high;
}

TWOGRID_VECTORISED void means_around(std::size_t n, double factor, const std::ptrdiff_t* at, std::ptrdiff_t sa,
                                     const double* share_a, std::ptrdiff_t sb, const double* share_b,
                                     const double* field, double* __restrict mean) {
#pragma GCC ivdep
  for (std::size_t q = 0; q < n; ++q)
    mean[q] =
        factor * mean_around(at[q], sa, share_a[q], sb, share_b[q], [field](std::ptrdiff_t m) { return field[m]; });
}

/// mu e (du_c/dx_c - 2/3 div u) of the three components.
TWOGRID_VECTORISED void stresses_in_cells(std::size_t n, double mu, const std::ptrdiff_t* at, std::ptrdiff_t sy,
                                          std::ptrdiff_t sz, const double* ix, const double* iy, const double* iz,
                                          const double* e, const double* u, const double* v, const double* w,
                                          double* __restrict x, double* __restrict y, double* __restrict z) {
#pragma GCC ivdep
  for (std::size_t q = 0; q < n; ++q) {
    const std::ptrdiff_t m = at[q];
    const double du = (u[m + 1] - u[m]) * ix[q], dv = (v[m + sy] - v[m]) * iy[q], dw = (w[m + sz] - w[m]) * iz[q];
    const double third = 2.0 / 3 * (du + dv + dw), g = mu * e[m];
    x[q] = g * (du - third), y[q] = g * (dv - third), z[q] = g * (dw - third);
  }
}

}  // namespace

CutLinks::CutLinks(const GridMeasures& measures, const std::array<Box, 3>& faces, const std::array<bool, 3>& solved)
    : measures_(measures) {
  const OpenShares& open = *measures.open();
  if (!open.has_links()) return;
  for (auto& p : places_) p.assign(open.theta().size(), -1);
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
    if (solved[c]) list_transposed(c, faces[c], solved), list_moved(c, faces[c]);
  places_ = {};
  for (Edges& e : edges_) e.in_links.resize(e.at.size());
  for (auto& s : cells_.stress) s.resize(cells_.at.size());
}

/// Between a face and the next one above in d, if nothing parts them.
bool CutLinks::link_above(int c, int d, const Int3& x, Link& link) {
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
  link = {
      m, -1, through / theta[m], {open.centre(c, m), open.centre(c, m + sd)}, open.drift(c, m + sd) - open.drift(c, m)};
  if (c == d) return true;
  const AxisMeasure &own = measures_.axis(c), &other = measures_.axis(d);
  link.edge = place_of_edge(3 - c - d, edge);
  link.conductance =
      through / mean_around(m + sd, sc, own.above_share_[edge[c] - own.lo], sd, other.above_share_[edge[d] - other.lo],
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
    struct Uncut {
      Int3 at;
      double factor;
    };
    std::array<std::vector<Uncut>, 3> uncut;
    bool cut = false;
    for (bool up : {false, true}) {
      const double sign = up ? 1 : -1;
      for (int d = 0; d < 3; ++d) {
        if (!solved[d]) continue;
        if (d == c) {
          if (!((up ? above : below) > 0)) continue;
          const std::ptrdiff_t at = up ? m : m - sc;
          cut = cut || open.cell().data()[at] == 0;
          const double area = width((c + 1) % 3) * width((c + 2) % 3);
          Int3 cell = x;
          cell[c] -= !up;
          if (open.cell().data()[at] != 0) uncut[d].push_back({cell, sign * area / theta.data()[at]});
        } else {
          const std::ptrdiff_t at = up ? m + theta.stride(d) : m;
          const CellField<FineGrid>& edge = open.edge(3 - c - d);
          cut = cut || edge.data()[at] == 0;
          const double area = (below + above) * width(3 - c - d);
          Int3 low = x;
          low[d] += up;
          // The factor of the edge is 1 over the mean of theta around it.
          if (edge.data()[at] != 0)
            uncut[d].push_back({low, sign * area / measures_.axis(c).face_width(x[c]) * edge.data()[at]});
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
    for (int d = 0; d < 3; ++d)
      for (const Uncut& t : uncut[d])
        transposed_[c][d].push_back(
            {slot, d == c ? place_of_cell(t.at, solved) : place_of_edge(3 - c - d, t.at), t.factor});
  });
}

int CutLinks::place_of_edge(int t, const Int3& x) {
  const std::ptrdiff_t m = measures_.open()->theta().index(x[0], x[1], x[2]);
  int& place = places_[t][std::size_t(m)];
  if (place >= 0) return place;
  const auto share = [&](int d) { return measures_.axis(d).above_share_[x[d] - measures_.axis(d).lo]; };
  edges_[t].at.push_back(m);
  edges_[t].share_a.push_back(share((t + 1) % 3)), edges_[t].share_b.push_back(share((t + 2) % 3));
  return place = int(edges_[t].at.size()) - 1;
}

int CutLinks::place_of_cell(const Int3& x, const std::array<bool, 3>& solved) {
  const std::ptrdiff_t m = measures_.open()->theta().index(x[0], x[1], x[2]);
  int& place = places_[3][std::size_t(m)];
  if (place >= 0) return place;
  cells_.at.push_back(m);
  for (int d = 0; d < 3; ++d) cells_.inverse[d].push_back(solved[d] ? 1 / measures_.axis(d).width(x[d]) : 0.0);
  return place = int(cells_.at.size()) - 1;
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

/// Of faces beside walls that move: u - u_r in place of u, in what is a face's own. Links that two faces share take the
/// change of u_r between their centres along with that of u (drift); each takes it off again as its own wall has it.
void CutLinks::list_moved(int c, const Box& faces) {
  const OpenShares& open = *measures_.open();
  const std::vector<std::ptrdiff_t>& rows = faces_[c];
  for (int d = 0; d < 3; ++d) {
    for (const Link& link : links_[c][d]) moving_ = moving_ || link.drift != 0;
    for (const Steeper& s : steeper_[c][d])
      if (s.link.drift != 0)
        moved_[c][d].push_back(
            {s.slot, s.up ? s.link.drift : -s.link.drift, s.link, true, int(&s - steeper_[c][d].data())});
  }
  moving_ = moving_ || !open.beside().empty();
  for (const OpenSpace::Beside& b : open.beside()) {
    if (b.component != c || !faces.contains(b.face[0], b.face[1], b.face[2])) continue;
    const std::ptrdiff_t m = open.theta().index(b.face[0], b.face[1], b.face[2]);
    const auto row = std::lower_bound(rows.begin(), rows.end(), m);
    if (row == rows.end() || *row != m) continue;
    const int slot = int(row - rows.begin());
    const double steeper = open.viscous(c, m) - 1;
    for (int d = 0; d < 3; ++d) {
      if (d == c || b.slope[d] == 0) continue;
      for (bool up : {false, true}) {
        Int3 lower = b.face;
        if (!up) --lower[d];
        const double change = (up ? -1 : 1) * b.slope[d] * measures_.axis(d).face_width(lower[d] + 1);
        Moved own{slot, change, {}, false};
        const std::ptrdiff_t edge = up ? m + open.theta().stride(d) : m;
        if (!link_above(c, d, lower, own.link)) continue;
        if (open.edge(3 - c - d).data()[edge] == 0) moved_[c][d].push_back(own);
        if (steeper == 0) continue;
        own.exceeds = true, own.link.conductance *= steeper;
        moved_[c][d].push_back(own);
      }
      const double across = -b.slope[d] * measures_.axis(c).face_width(b.face[c]);  // change of u_r's d along c
      for (const Transposed& t : transposed_[c][d])
        if (t.slot == slot) moved_sides_[c][d].push_back({slot, t.place, t.factor * across});
    }
  }
}

void CutLinks::renew_walls() {
  const OpenShares& open = *measures_.open();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const auto renew = [&](Link& link) {
        link.drift = open.drift(c, link.lower + open.theta().stride(d)) - open.drift(c, link.lower);
      };
      for (Link& link : links_[c][d]) renew(link);
      for (Steeper& s : steeper_[c][d]) renew(s.link);
      for (Moved& w : moved_[c][d]) {
        if (w.steeper < 0) continue;
        const Steeper& s = steeper_[c][d][w.steeper];
        w.link = s.link, w.change = s.up ? s.link.drift : -s.link.drift;
      }
    }
}

/// Of edges: mu eps, with the harmonic mean of mu; in links over what is open around.
void CutLinks::set_means(const Property& mu, const CellField<FineGrid>& e) {
  const double* theta = measures_.open()->theta().data();
  const double* viscosity = mu.varies() ? mu.field().data() : nullptr;
  for (int t = 0; t < 3; ++t) {
    Edges& edges = edges_[t];
    const std::size_t n = edges.at.size();
    const std::ptrdiff_t sa = e.stride((t + 1) % 3), sb = e.stride((t + 2) % 3);
    means_around(n, viscosity ? 1.0 : mu.number, edges.at.data(), sa, edges.share_a.data(), sb, edges.share_b.data(),
                 e.data(), edges.in_links.data());
    if (!viscosity) continue;
    edges.in_gradients.resize(n);
    for (std::size_t q = 0; q < n; ++q) {
      const auto mean = [&](auto&& of) {
        return mean_around(edges.at[q], sa, edges.share_a[q], sb, edges.share_b[q], of);
      };
      const double eps = edges.in_links[q];
      edges.in_gradients[q] = eps / mean([viscosity](std::ptrdiff_t m) { return 1 / viscosity[m]; });
      edges.in_links[q] = eps * mean([theta](std::ptrdiff_t m) { return theta[m]; }) /
                          mean([theta, viscosity](std::ptrdiff_t m) { return theta[m] / viscosity[m]; });
    }
  }
}

void CutLinks::set_stresses(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u) {
  const std::size_t n = cells_.at.size();
  stresses_in_cells(n, mu.varies() ? 1.0 : mu.number, cells_.at.data(), e.stride(1), e.stride(2),
                    cells_.inverse[0].data(), cells_.inverse[1].data(), cells_.inverse[2].data(), e.data(), u[0].data(),
                    u[1].data(), u[2].data(), cells_.stress[0].data(), cells_.stress[1].data(),
                    cells_.stress[2].data());
  if (!mu.varies()) return;
  for (auto& stress : cells_.stress)
    for (std::size_t q = 0; q < n; ++q) stress[q] *= mu.field().data()[cells_.at[q]];
}

/// mu eps a A/h, after set_means().
inline double CutLinks::conductance(int c, int d, const Link& link, const Property& mu, const double* held) const {
  if (c != d) return edges_[3 - c - d].in_links[link.edge] * link.conductance;
  return (mu.varies() ? mu.field().data()[link.lower] : mu.number) * held[link.lower] * link.conductance;
}

/// After set_means().
void CutLinks::sum_left_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u) {
  set_stresses(mu, e, u);
  for (int c = 0; c < 3; ++c) {
    left_out_[c].assign(faces_[c].size(), 0.0), exceeding_[c].assign(faces_[c].size(), 0.0);
    double *left_out = left_out_[c].data(), *exceeding = exceeding_[c].data();
    const std::ptrdiff_t sc = e.stride(c);
    for (int d = 0; d < 3; ++d) {
      if (d == c) {
        const double* stress = cells_.stress[c].data();
        for (const Transposed& t : transposed_[c][d]) left_out[t.slot] += stress[t.place] * t.factor;
      } else {
        const Edges& edges = edges_[3 - c - d];
        const double *v = u[d].data(), *mu_eps = (mu.varies() ? edges.in_gradients : edges.in_links).data();
        const std::ptrdiff_t* at = edges.at.data();
        for (const Transposed& t : transposed_[c][d]) {
          const std::ptrdiff_t m = at[t.place];
          left_out[t.slot] += mu_eps[t.place] * t.factor * (v[m] - v[m - sc]);
        }
      }
      const double* v = u[c].data();
      const std::ptrdiff_t sd = e.stride(d);
      for (const Steeper& s : steeper_[c][d]) {
        const double change = s.link.centre[1] * v[s.link.lower + sd] - s.link.centre[0] * v[s.link.lower];
        exceeding[s.slot] -= (s.up ? change : -change) * conductance(c, d, s.link, mu, e.data());
      }
    }
    for (std::size_t q = 0; q < faces_[c].size(); ++q) left_out[q] += exceeding[q];
  }
}

template <class F>
inline void CutLinks::for_each_moved(const Property& mu, const CellField<FineGrid>& e, F&& f) const {
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      for (const Moved& w : moved_[c][d]) f(c, w.slot, w.change * conductance(c, d, w.link, mu, e.data()), w.exceeds);
      if (c == d) continue;
      const Edges& edges = edges_[3 - c - d];
      const double* mu_eps = (mu.varies() ? edges.in_gradients : edges.in_links).data();
      for (const Transposed& t : moved_sides_[c][d]) f(c, t.slot, mu_eps[t.place] * t.factor, false);
    }
}

void CutLinks::add_moving(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& out) {
  if (!moving_) return;
  set_means(mu, e);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (const Link& link : links_[c][d]) {
        const double force = conductance(c, d, link, mu, e.data()) * link.drift;
        out[c].data()[link.lower] += force;
        out[c].data()[link.lower + e.stride(d)] -= force;
      }
  for_each_moved(mu, e, [&](int c, int slot, double f, bool) { out[c].data()[faces_[c][slot]] += f; });
}

void CutLinks::leave_moving_out(const Property& mu, const CellField<FineGrid>& e) {
  if (!moving_) return;
  set_means(mu, e);
  for_each_moved(mu, e, [&](int c, int slot, double f, bool exceeds) {
    left_out_[c][slot] -= f;
    if (exceeds) exceeding_[c][slot] -= f;
  });
}

void CutLinks::leave_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u) {
  set_means(mu, e);
  sum_left_out(mu, e, u);
}

void CutLinks::add(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                   FaceField<FineGrid>& out) {
  leave_out(mu, e, u);
  for (int c = 0; c < 3; ++c) {
    const double* v = u[c].data();
    double* o = out[c].data();
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t sd = e.stride(d);
      for (const Link& link : links_[c][d]) {
        const double force = conductance(c, d, link, mu, e.data()) *
                             (link.centre[1] * v[link.lower + sd] - link.centre[0] * v[link.lower]);
        o[link.lower] += force;
        o[link.lower + sd] -= force;
      }
    }
    for (std::size_t q = 0; q < faces_[c].size(); ++q) o[faces_[c][q]] -= left_out_[c][q];
  }
}

void CutLinks::add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) {
  set_means(mu, e);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      double* o = diagonal[c].data();
      for (const Link& link : links_[c][d]) {
        const double g = conductance(c, d, link, mu, e.data());
        o[link.lower] += link.centre[0] * g;
        o[link.lower + e.stride(d)] += link.centre[1] * g;
      }
      for (const Steeper& s : steeper_[c][d])
        o[faces_[c][s.slot]] += s.link.centre[s.up ? 0 : 1] * conductance(c, d, s.link, mu, e.data());
    }
}

}  // namespace twogrid
