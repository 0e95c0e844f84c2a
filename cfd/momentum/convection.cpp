#include "cfd/momentum/convection.h"

#include <cmath>
#include <utility>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// van Leer's (1974) increment of a value from a cell's centre to its side: the distance times the harmonic mean of the
/// slopes before and behind; zero at an extremum.
inline double limited_change(double distance, double slope, double behind) {
  const double p = slope * behind;
  const bool rises = p > 0;
  return distance * 2 * (rises ? p : 0.0) / (rises ? slope + behind : 1.0);
}

/// The part of a velocity's change between two neighbouring faces that a void fraction explains which changes while
/// the flux F does not, F (1/e_hi - 1/e_lo): of the same sign as the whole change and no larger.
inline double explained(double change, double F, double e_lo, double e_hi) {
  const double by_eps = F * (e_lo - e_hi) / (e_lo * e_hi);
  const double smaller = std::abs(by_eps) < std::abs(change) ? by_eps : change;
  return change * by_eps > 0 ? smaller : 0.0;
}

/// Velocity transported along itself through a cell's centre, from the faces below (v[lower]) and above it, limited.
/// What the void fraction explains of a change is no front: it is taken centrally, the limiter sees the rest. Where F =
/// eps u is uniform the sum of u_f (u_c - u_c below) = (u_f^2)/2 then telescopes, so that eps grad p balances at any
/// jump of eps with no loss of head; a limited value would lose up to (jump of u)^2/2 there, on any grid. A uniform u
/// is kept whatever eps does, and the value lies between those of the two faces.
/// inverse_*: of the distances between the faces below, around and above.
inline double transported_along(const double* v, const double* e, std::ptrdiff_t lower, std::ptrdiff_t s, bool up,
                                double inverse_below, double dist, double inverse, double inverse_above) {
  const std::ptrdiff_t below = lower - s, upper = lower + s, above = upper + s;
  const double change = v[upper] - v[lower];
  const double by_eps = explained(change, 0.5 * (e[lower] * v[lower] + e[upper] * v[upper]), e[lower], e[upper]);
  // All are read, whichever counts: else a loop would not vectorise.
  const double v0 = v[below], v1 = v[lower], v2 = v[upper], v3 = v[above];
  const double f0 = e[below], f1 = e[lower], f2 = e[upper], f3 = e[above];
  const double b0 = up ? v0 : v2, b1 = up ? v1 : v3;
  const double e0 = up ? f0 : f2, e1 = up ? f1 : f3;
  const double behind = b1 - b0 - explained(b1 - b0, 0.5 * (e0 * b0 + e1 * b1), e0, e1);
  const double half =
      0.5 * (by_eps + limited_change(dist, (change - by_eps) * inverse, behind * (up ? inverse_below : inverse_above)));
  return up ? v[lower] + half : v[upper] - half;
}

}  // namespace

ConvectionTerm::ConvectionTerm(const FineGrid& grid, const GridMeasures& measures, const Box& own, const Box& local,
                               const std::array<Box, 3>& faces, const std::array<bool, 3>& solved)
    : own_(own),
      local_(local),
      faces_(faces),
      rows_{measures.open_surroundings(0), measures.open_surroundings(1), measures.open_surroundings(2)},
      solved_(solved),
      axis_{measures.axis(0), measures.axis(1), measures.axis(2)},
      periodic_(grid.periodic()),
      n_(grid.n()) {
  const std::size_t row = local.size(0);
  side_[0].resize(row), side_[1].resize(2 * row), side_[2].resize(2 * row * local.size(1));
  if (measures.open() && measures.open()->has_links()) list_cut_sides(*measures.open());
}

void ConvectionTerm::list_cut_sides(const OpenShares& open) {
  const auto& theta = open.theta();
  central_.reset(local_, 0);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      if (!solved_[c] || !solved_[d] || faces_[c].empty()) continue;
      const std::ptrdiff_t s = theta.stride(d);
      Box upper = faces_[c];
      ++upper.hi[d];
      const int last = c == d ? n_[d] : n_[d] - 1;
      for_each(upper, [&](int i, int j, int k) {
        const Int3 x{i, j, k};
        if (!periodic_[d] && (x[d] < 1 || x[d] > last)) return;
        const std::ptrdiff_t m = theta.index(i, j, k);
        const auto cut = [&](std::ptrdiff_t lower) {
          return !(open.alpha(c, lower) > 0 && open.alpha(c, lower + s) > 0 && open.linked(c, d, lower));
        };
        // Where both faces that carry through a side are closed nothing passes it.
        const std::ptrdiff_t other = m - (c == d ? s : theta.stride(c));
        if (!(open.alpha(d, m) > 0 || open.alpha(d, other) > 0)) return;
        const bool between = cut(m - s), above = m + s < std::ptrdiff_t(theta.size()) && cut(m);
        if (between) list_moving_side(open, c, d, x, m);
        if (between || cut(m - 2 * s)) central_.data()[m] |= central_if(c, d, true);
        if (between || above) central_.data()[m] |= central_if(c, d, false);
      });
    }
}

void ConvectionTerm::list_moving_side(const OpenShares& open, int c, int d, const Int3& x, std::ptrdiff_t m) {
  const std::ptrdiff_t s = open.theta().stride(d);
  const bool low = open.alpha(c, m - s) > 0, high = open.alpha(c, m) > 0;
  if (low == high) return;
  const std::ptrdiff_t closed = low ? m : m - s;
  const double velocity = open.wall_velocity(c, closed);
  if (velocity == 0) return;
  const auto width = [&](int e, int i) { return axis_[e].width(i); };
  if (c == d) {
    const double part = 0.25 * width((c + 1) % 3, x[(c + 1) % 3]) * width((c + 2) % 3, x[(c + 2) % 3]);
    moving_sides_[c][d].push_back({m, m - s, 0, 0, closed, part, 1, 1});
    moving_sides_[c][d].back().move(velocity);
    return;
  }
  const double of_upper = 0.5 * width(d, x[d] - 1) / axis_[d].face_width(x[d]);
  const double part = (low ? of_upper : 1 - of_upper) * width(3 - c - d, x[3 - c - d]);
  moving_sides_[c][d].push_back(
      {m, m - open.theta().stride(c), 0, 0, closed, part, axis_[c].half_above(x[c]), axis_[c].half_below(x[c])});
  moving_sides_[c][d].back().move(velocity);
}

void ConvectionTerm::renew_walls(const OpenShares& open) {
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (MovingSide& w : moving_sides_[c][d]) w.move(open.wall_velocity(c, w.closed));
}

struct ConvectionTerm::Convected {
  double rho;
  const FaceField<FineGrid>&eps_f, &u;
};

/// q = mass flux times velocity through the low side in d of the volumes (i.., j, k) of component c.
/// cut: where the limiter would compare a slope with one to a wall, or through one, the mean of the two faces is taken.
template <int c, int d, bool limited, bool cut>
inline void ConvectionTerm::side_row(const Convected& a, int i, int j, int k, int count, double* __restrict q) const {
  constexpr int e = c == d ? (c + 1) % 3 : 3 - c - d, f = (c + 2) % 3;  // transverse directions
  const Int3 x{i, j, k};
  const std::ptrdiff_t m = a.u[c].index(i, j, k), sc = a.u[c].stride(c), s = a.u[c].stride(d);
  // cppcheck-suppress negativeContainerIndex ; the other branch is taken where c is d
  const AxisMeasure &ac = axis_[c], &ad = axis_[d], &ae = axis_[e], &af = axis_[f];
  const double *v = a.u[c].data() + m, *eps = a.eps_f[d].data() + m, *through = a.u[d].data() + m;
  const auto F = [eps, through](std::ptrdiff_t t) { return eps[t] * through[t]; };
  const double rho = a.rho;
  const long long* central = cut ? central_.data() + m : nullptr;
  constexpr long long flow_up = central_if(c, d, true), flow_down = central_if(c, d, false);
  const auto we = along_row<e>(ae.width_, x[e] - ae.lo);
  // Sides on, or beyond, the domain's.
  const int first = 0, last = c == d ? n_[d] + 1 : n_[d];
  auto outermost = [&](int t, bool high) {
    if (c == d) {
      // The outer side of an outlet's half volume is the outlet's face itself.
      const std::ptrdiff_t face = high ? t - s : t;
      q[t] = rho * (F(face) * we[t] * along_row<f>(af.width_, x[f] - af.lo)[t]) * v[face];
    } else {
      const double flow = F(t - sc) * along_row<c>(ac.half_below_, x[c] - ac.lo)[t] +
                          F(t) * along_row<c>(ac.half_above_, x[c] - ac.lo)[t];
      q[t] = rho * (flow * we[t]) * (0.5 * (v[t - s] + v[t]));  // the side's own value
    }
  };
  int begin = 0, end = count;
  if (!periodic_[d]) {
    if (d != 0 && (x[d] == first || x[d] == last)) {
      for (int t = 0; t < count; ++t) outermost(t, x[d] == last);
      return;
    }
    if (d == 0 && i == first) outermost(0, false), begin = 1;
    if (d == 0 && i + count - 1 == last) outermost(count - 1, true), end = count - 1;
  }
  if constexpr (c == d) {
    const int o = x[c] - 1 - ac.lo;  // the cell between the two faces
    const auto wf = along_row<f>(af.width_, x[f] - af.lo);
    const auto dist = along_row<c>(ac.width_, o);
    const auto below = along_row<c>(ac.inverse_width_, o - 1), inverse = along_row<c>(ac.inverse_width_, o),
               above = along_row<c>(ac.inverse_width_, o + 1);
#pragma GCC ivdep
    for (int t = begin; t < end; ++t) {
      const double flow = 0.5 * (F(t - s) + F(t)) * we[t] * wf[t];
      double value = 0;
      if constexpr (limited)
        value = transported_along(v, eps, t - s, s, flow >= 0, below[t], dist[t], inverse[t], above[t]);
      if constexpr (!limited || cut) {
        const double mean = v[t - s] + (v[t] - v[t - s]) * (0.5 * dist[t] * inverse[t]);
        value = !limited || (central[t] & (flow >= 0 ? flow_up : flow_down)) != 0 ? mean : value;
      }
      q[t] = rho * flow * value;
    }
  } else {
    const int o = x[d] - ad.lo;
    const auto hb = along_row<c>(ac.half_below_, x[c] - ac.lo), ha = along_row<c>(ac.half_above_, x[c] - ac.lo);
    const auto below = along_row<d>(ad.inverse_face_width_, o - 1), inverse = along_row<d>(ad.inverse_face_width_, o),
               above = along_row<d>(ad.inverse_face_width_, o + 1);
    const auto w_lower = along_row<d>(ad.width_, o - 1), w_upper = along_row<d>(ad.width_, o);
#pragma GCC ivdep
    for (int t = begin; t < end; ++t) {
      const double flow = (F(t - sc) * hb[t] + F(t) * ha[t]) * we[t];
      const double slope = (v[t] - v[t - s]) * inverse[t];
      double value = 0;
      if constexpr (limited) {
        const bool up = flow >= 0;
        const double v0 = v[t - 2 * s], v1 = v[t - s], v2 = v[t], v3 = v[t + s], inverse_0 = below[t],
                     inverse_1 = above[t], width_0 = w_lower[t], width_1 = w_upper[t];
        const double behind = (up ? v1 - v0 : v3 - v2) * (up ? inverse_0 : inverse_1);
        const double change = limited_change(0.5 * (up ? width_0 : width_1), slope, behind);
        value = up ? v[t - s] + change : v[t] - change;
      }
      if constexpr (!limited || cut) {
        const double mean = v[t - s] + slope * (0.5 * w_lower[t]);
        value = !limited || (central[t] & (flow >= 0 ? flow_up : flow_down)) != 0 ? mean : value;
      }
      q[t] = rho * flow * value;
    }
  }
}

/// Of a row of own faces: what has to be worked on. None beyond the last rows.
inline OpenRows::Part ConvectionTerm::part(int c, int j, int k) const {
  const Box& b = faces_[c];
  return j < b.hi[1] && k < b.hi[2] ? rows_[c]->at(j, k) : OpenRows::Part{b.lo[0], b.lo[0]};
}

/// whole: all rows have their whole length.
template <int c, bool limited, bool whole, bool cut>
inline void ConvectionTerm::convect_component(const Convected& a, Array3<double>& out) {
  using Part = OpenRows::Part;
  const Box b = faces_[c];
  const int first = b.lo[0], row = local_.size(0);
  const Part all{b.lo[0], b.hi[0]};
  const auto part_of = [&](int j, int k) { return whole ? all : part(c, j, k); };
  const auto both = [&](const Part& p, int j, int k) { return whole ? all : OpenRows::hull(p, part(c, j, k)); };
  const std::size_t slab = std::size_t(row) * local_.size(1);
  double* x_side = side_[0].data();
  double *y_low = side_[1].data(), *y_high = y_low + row;
  double *z_low = side_[2].data(), *z_high = z_low + slab;
  auto z_row = [&](double* z, int j) { return z + std::size_t(row) * (j - b.lo[1]); };
  if (solved_[2])
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      const Part p = part_of(j, b.lo[2]);
      if (whole || p.size() > 0)
        side_row<c, 2, limited, cut>(a, p.begin, j, b.lo[2], p.size(), z_row(z_low, j) + (p.begin - first));
    }
  for (int k = b.lo[2]; k < b.hi[2]; ++k) {
    const Part lowest = part_of(b.lo[1], k);
    if (solved_[1] && (whole || lowest.size() > 0))
      side_row<c, 1, limited, cut>(a, lowest.begin, b.lo[1], k, lowest.size(), y_low + (lowest.begin - first));
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      // A side is computed as far as the row below it or the one above it needs it.
      const Part p = part_of(j, k);
      const int at = p.begin - first, n = p.size();
      double* o = out.data() + out.index(p.begin, j, k);
      if (solved_[0] && (whole || n > 0)) {
        side_row<c, 0, limited, cut>(a, p.begin, j, k, n + 1, x_side);
        for (int i = 0; i < n; ++i) o[i] -= x_side[i + 1] - x_side[i];
      }
      if (solved_[1]) {
        const Part q = both(p, j + 1, k);
        if (whole || q.size() > 0)
          side_row<c, 1, limited, cut>(a, q.begin, j + 1, k, q.size(), y_high + (q.begin - first));
        for (int i = 0; i < n; ++i) o[i] -= y_high[at + i] - y_low[at + i];
        std::swap(y_low, y_high);
      }
      if (solved_[2]) {
        double *low = z_row(z_low, j), *high = z_row(z_high, j);
        const Part q = both(p, j, k + 1);
        if (whole || q.size() > 0)
          side_row<c, 2, limited, cut>(a, q.begin, j, k + 1, q.size(), high + (q.begin - first));
        for (int i = 0; i < n; ++i) o[i] -= high[at + i] - low[at + i];
      }
    }
    std::swap(z_low, z_high);
  }
}

void ConvectionTerm::add(double rho, const FaceField<FineGrid>& eps_f, const FaceField<FineGrid>& u, Convection scheme,
                         FaceField<FineGrid>& out) {
  if (scheme == Convection::kNone || own_.empty()) return;
  const Convected a{rho, eps_f, u};
  if (scheme == Convection::kVanLeer) {
    central_.size() > 0 ? convect_limited_beside_links(a, out)
    : rows_[0]          ? convect_limited_between_bodies(a, out)
                        : convect_limited(a, out);
  } else {
    rows_[0] ? convect_central_between_bodies(a, out) : convect_central(a, out);
  }
  carry_walls(a, out);
}

/// Closed faces hold no velocity; on sides that they share with open ones, walls that move have theirs.
void ConvectionTerm::carry_walls(const Convected& a, FaceField<FineGrid>& out) const {
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      const double *e = a.eps_f[d].data(), *v = a.u[d].data();
      for (const MovingSide& w : moving_sides_[c][d]) {
        const double q = a.rho * (e[w.upper] * v[w.upper] * w.here + e[w.other] * v[w.other] * w.there);
        out[c].data()[w.upper] += q;
        out[c].data()[w.upper - out[c].stride(d)] -= q;
      }
    }
}

TWOGRID_VECTORISED void ConvectionTerm::convect_limited(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, true, true, false>(a, out[0]);
  if (solved_[1]) convect_component<1, true, true, false>(a, out[1]);
  if (solved_[2]) convect_component<2, true, true, false>(a, out[2]);
}

TWOGRID_VECTORISED void ConvectionTerm::convect_limited_between_bodies(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, true, false, false>(a, out[0]);
  if (solved_[1]) convect_component<1, true, false, false>(a, out[1]);
  if (solved_[2]) convect_component<2, true, false, false>(a, out[2]);
}

TWOGRID_VECTORISED void ConvectionTerm::convect_limited_beside_links(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, true, false, true>(a, out[0]);
  if (solved_[1]) convect_component<1, true, false, true>(a, out[1]);
  if (solved_[2]) convect_component<2, true, false, true>(a, out[2]);
}

TWOGRID_VECTORISED void ConvectionTerm::convect_central(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, false, true, false>(a, out[0]);
  if (solved_[1]) convect_component<1, false, true, false>(a, out[1]);
  if (solved_[2]) convect_component<2, false, true, false>(a, out[2]);
}

TWOGRID_VECTORISED void ConvectionTerm::convect_central_between_bodies(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, false, false, false>(a, out[0]);
  if (solved_[1]) convect_component<1, false, false, false>(a, out[1]);
  if (solved_[2]) convect_component<2, false, false, false>(a, out[2]);
}

double ConvectionTerm::convected_through(int c, int i, int j, int k, double rho, const FaceField<FineGrid>& eps_f,
                                         const FaceField<FineGrid>& u, Convection scheme) const {
  if (scheme == Convection::kNone) return 0;
  const Int3 x{i, j, k};
  const std::ptrdiff_t s = u[c].stride(c), m = u[c].index(i, j, k);
  const AxisMeasure& a = axis_[c];
  const double *v = u[c].data(), *e = eps_f[c].data();
  const double flow = 0.5 * (e[m] * v[m] + e[m + s] * v[m + s]) * axis_[(c + 1) % 3].width(x[(c + 1) % 3]) *
                      axis_[(c + 2) % 3].width(x[(c + 2) % 3]);
  if (scheme == Convection::kVanLeer)
    return rho * flow *
           transported_along(v, e, m, s, flow >= 0, 1 / a.width(x[c] - 1), a.width(x[c]), 1 / a.width(x[c]),
                             1 / a.width(x[c] + 1));
  return rho * flow * 0.5 * (v[m] + v[m + s]);
}

}  // namespace twogrid
