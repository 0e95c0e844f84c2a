#include "cfd/momentum/momentum.h"

#include <cmath>
#include <utility>

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
  const double b0 = up ? v[below] : v[upper], b1 = up ? v[lower] : v[above];
  const double e0 = up ? e[below] : e[upper], e1 = up ? e[lower] : e[above];
  const double behind = b1 - b0 - explained(b1 - b0, 0.5 * (e0 * b0 + e1 * b1), e0, e1);
  const double half =
      0.5 * (by_eps + limited_change(dist, (change - by_eps) * inverse, behind * (up ? inverse_below : inverse_above)));
  return up ? v[lower] + half : v[upper] - half;
}

}  // namespace

Momentum::Momentum(const FineGrid& grid, const Box& own, const Box& local, const std::array<Box, 3>& faces,
                   const std::array<bool, 3>& solved)
    : own_(own), local_(local), faces_(faces), solved_(solved), periodic_(grid.periodic()), n_(grid.n()) {
  for (int d = 0; d < 3; ++d) {
    AxisMeasure& m = axis_[d];
    const Axis& a = grid.axis[d];
    m.lo = own.lo[d] - 2;  // even where the fields have no halo
    for (int i = m.lo; i < own.hi[d] + 2; ++i) {
      m.width_.push_back(a.width(i));
      m.face_width_.push_back(a.face_width(i));
      m.inverse_width_.push_back(1 / a.width(i));
      m.inverse_face_width_.push_back(1 / a.face_width(i));
      m.above_share_.push_back(a.width(i) / (a.width(i - 1) + a.width(i)));
      const bool below_in = a.periodic() || i - 1 >= 0, above_in = a.periodic() || i < a.n();
      m.half_below_.push_back(below_in ? 0.5 * a.width(i - 1) : 0.0);
      m.half_above_.push_back(above_in ? 0.5 * a.width(i) : 0.0);
    }
  }
  const std::size_t row = local.size(0), slab = row * local.size(1);
  for (auto* s : {&normal_[0], &normal_[1], &normal_[2], &normal_below_}) s->assign(slab, 0.0);
  for (auto* s : {&shear_[0], &shear_[1], &shear_[2], &shear_above_[0], &shear_above_[1]}) s->assign(slab, 0.0);
  side_[0].resize(row), side_[1].resize(2 * row), side_[2].resize(2 * row * local.size(1));
}

namespace {

/// f = the mean of two neighbouring cells with the given share of the upper one.
template <bool varies>
inline void mean_row(const double* e, std::ptrdiff_t s, AlongRow<varies> share, int n, double* f) {
  for (int i = 0; i < n; ++i) f[i] = e[i - s] + share[i] * (e[i] - e[i - s]);
}

TWOGRID_VECTORISED void mean_rows(const Array3<double>& eps, int c, const Box& b, const double* share,
                                  Array3<double>& out) {
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      const std::ptrdiff_t m = eps.index(b.lo[0], j, k), s = eps.stride(c);
      const double* e = eps.data() + m;
      double* f = out.data() + m;
      if (c == 0)
        mean_row(e, s, AlongRow<true>{share}, b.size(0), f);
      else
        mean_row(e, s, AlongRow<false>{share + (c == 1 ? j - b.lo[1] : k - b.lo[2])}, b.size(0), f);
    }
}

}  // namespace

void Momentum::face_mean(const CellField<FineGrid>& eps, FaceField<FineGrid>& eps_f) const {
  if (own_.empty()) return;
  for (int c = 0; c < 3; ++c) {
    Box b = local_;
    if (eps.stride(c) > 0) ++b.lo[c];
    mean_rows(eps, c, b, &axis_[c].above_share_[b.lo[c] - axis_[c].lo], eps_f[c]);
  }
}

struct Momentum::Convected {
  double rho;
  const FaceField<FineGrid>&eps_f, &u;
};

/// q = mass flux times velocity through the low side in d of the volumes (i.., j, k) of component c.
template <int c, int d, bool limited>
inline void Momentum::side_row(const Convected& a, int i, int j, int k, int count, double* __restrict q) const {
  constexpr int e = c == d ? (c + 1) % 3 : 3 - c - d, f = (c + 2) % 3;  // transverse directions
  const Int3 x{i, j, k};
  const std::ptrdiff_t m = a.u[c].index(i, j, k), sc = a.u[c].stride(c), s = a.u[c].stride(d);
  const AxisMeasure &ac = axis_[c], &ad = axis_[d], &ae = axis_[e], &af = axis_[f];
  const double *v = a.u[c].data() + m, *eps = a.eps_f[d].data() + m, *through = a.u[d].data() + m;
  const auto F = [eps, through](std::ptrdiff_t t) { return eps[t] * through[t]; };
  const double rho = a.rho;
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
    const auto wf = along_row<f>(af.width_, x[f] - af.lo), dist = along_row<c>(ac.width_, o);
    const auto below = along_row<c>(ac.inverse_width_, o - 1), inverse = along_row<c>(ac.inverse_width_, o),
               above = along_row<c>(ac.inverse_width_, o + 1);
    for (int t = begin; t < end; ++t) {
      const double flow = 0.5 * (F(t - s) + F(t)) * we[t] * wf[t];
      double value;
      if constexpr (limited)
        value = transported_along(v, eps, t - s, s, flow >= 0, below[t], dist[t], inverse[t], above[t]);
      else
        value = v[t - s] + (v[t] - v[t - s]) * (0.5 * dist[t] * inverse[t]);
      q[t] = rho * flow * value;
    }
  } else {
    const int o = x[d] - ad.lo;
    const auto hb = along_row<c>(ac.half_below_, x[c] - ac.lo), ha = along_row<c>(ac.half_above_, x[c] - ac.lo);
    const auto below = along_row<d>(ad.inverse_face_width_, o - 1), inverse = along_row<d>(ad.inverse_face_width_, o),
               above = along_row<d>(ad.inverse_face_width_, o + 1);
    const auto w_lower = along_row<d>(ad.width_, o - 1), w_upper = along_row<d>(ad.width_, o);
    for (int t = begin; t < end; ++t) {
      const double flow = (F(t - sc) * hb[t] + F(t) * ha[t]) * we[t];
      const double slope = (v[t] - v[t - s]) * inverse[t];
      double value;
      if constexpr (limited) {
        const bool up = flow >= 0;
        const double behind = ((up ? v[t - s] : v[t + s]) - (up ? v[t - 2 * s] : v[t])) * (up ? below[t] : above[t]);
        const double change = limited_change(0.5 * (up ? w_lower[t] : w_upper[t]), slope, behind);
        value = up ? v[t - s] + change : v[t] - change;
      } else {
        value = v[t - s] + slope * (0.5 * w_lower[t]);
      }
      q[t] = rho * flow * value;
    }
  }
}

template <int c, bool limited>
inline void Momentum::convect_component(const Convected& a, Array3<double>& out) {
  const Box& b = faces_[c];
  const int n = b.size(0), row = local_.size(0);
  const std::size_t slab = std::size_t(row) * local_.size(1);
  double* x_side = side_[0].data();
  double *y_low = side_[1].data(), *y_high = y_low + row;
  double *z_low = side_[2].data(), *z_high = z_low + slab;
  auto z_row = [&](double* z, int j) { return z + std::size_t(row) * (j - b.lo[1]); };
  if (solved_[2])
    for (int j = b.lo[1]; j < b.hi[1]; ++j) side_row<c, 2, limited>(a, b.lo[0], j, b.lo[2], n, z_row(z_low, j));
  for (int k = b.lo[2]; k < b.hi[2]; ++k) {
    if (solved_[1]) side_row<c, 1, limited>(a, b.lo[0], b.lo[1], k, n, y_low);
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      double* o = out.data() + out.index(b.lo[0], j, k);
      if (solved_[0]) {
        side_row<c, 0, limited>(a, b.lo[0], j, k, n + 1, x_side);
        for (int i = 0; i < n; ++i) o[i] -= x_side[i + 1] - x_side[i];
      }
      if (solved_[1]) {
        side_row<c, 1, limited>(a, b.lo[0], j + 1, k, n, y_high);
        for (int i = 0; i < n; ++i) o[i] -= y_high[i] - y_low[i];
        std::swap(y_low, y_high);
      }
      if (solved_[2]) {
        double *low = z_row(z_low, j), *high = z_row(z_high, j);
        side_row<c, 2, limited>(a, b.lo[0], j, k + 1, n, high);
        for (int i = 0; i < n; ++i) o[i] -= high[i] - low[i];
      }
    }
    std::swap(z_low, z_high);
  }
}

void Momentum::convect(double rho, const FaceField<FineGrid>& eps_f, const FaceField<FineGrid>& u, Convection scheme,
                       FaceField<FineGrid>& out) {
  if (scheme == Convection::kNone || own_.empty()) return;
  const Convected a{rho, eps_f, u};
  if (scheme == Convection::kVanLeer)
    convect_limited(a, out);
  else
    convect_central(a, out);
}

TWOGRID_VECTORISED void Momentum::convect_limited(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, true>(a, out[0]);
  if (solved_[1]) convect_component<1, true>(a, out[1]);
  if (solved_[2]) convect_component<2, true>(a, out[2]);
}

TWOGRID_VECTORISED void Momentum::convect_central(const Convected& a, FaceField<FineGrid>& out) {
  if (solved_[0]) convect_component<0, false>(a, out[0]);
  if (solved_[1]) convect_component<1, false>(a, out[1]);
  if (solved_[2]) convect_component<2, false>(a, out[2]);
}

double Momentum::convected_through(int c, int i, int j, int k, double rho, const FaceField<FineGrid>& eps_f,
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

/// Normal stresses in slab k of own cells, and of one more around where a direction is not left out.
inline void Momentum::normal_stresses(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k) {
  const int around = local_.size(1) > own_.size(1) ? 1 : 0;
  const int first = own_.lo[0] - 1, n = own_.size(0) + 2;
  const std::ptrdiff_t sy = eps.stride(1), sz = eps.stride(2), slab = eps.index(local_.lo[0], local_.lo[1], k);
  const double* ix = &axis_[0].inverse_width_[first - axis_[0].lo];
  for (int j = own_.lo[1] - around; j < own_.hi[1] + around; ++j) {
    const std::ptrdiff_t m = eps.index(first, j, k);
    const double iy = axis_[1].inverse_width_[j - axis_[1].lo], iz = axis_[2].inverse_width_[k - axis_[2].lo];
    const double *e = eps.data() + m, *ux = u[0].data() + m, *uy = u[1].data() + m, *uz = u[2].data() + m;
    double *__restrict nx = normal_[0].data() + (m - slab), *__restrict ny = normal_[1].data() + (m - slab),
                       *__restrict nz = normal_[2].data() + (m - slab);
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x = (ux[i + 1] - ux[i]) * ix[i], y = (uy[i + sy] - uy[i]) * iy, z = (uz[i + sz] - uz[i]) * iz;
      const double third = (x + y + z) * (1.0 / 3), g = 2 * mu * e[i];
      nx[i] = g * (x - third);
      ny[i] = g * (y - third);
      nz[i] = g * (z - third);
    }
  }
}

/// Shear stresses of the two directions other than t on edges; edge m is the low corner of cell m in both.
template <int t>
inline void Momentum::shear_stress(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k,
                                   Slab& out) const {
  constexpr int a = (t + 1) % 3, b = (t + 2) % 3;
  const AxisMeasure &aa = axis_[a], &ab = axis_[b];
  const int around = local_.size(1) > own_.size(1) ? 1 : 0, n = own_.size(0) + 1;
  const std::ptrdiff_t sa = eps.stride(a), sb = eps.stride(b), slab = eps.index(local_.lo[0], local_.lo[1], k);
  for (int j = own_.lo[1]; j < own_.hi[1] + around; ++j) {
    const std::ptrdiff_t m = eps.index(own_.lo[0], j, k);
    const Int3 x{own_.lo[0], j, k};
    const auto ha = along_row<a>(aa.above_share_, x[a] - aa.lo), hb = along_row<b>(ab.above_share_, x[b] - ab.lo);
    const auto ia = along_row<a>(aa.inverse_face_width_, x[a] - aa.lo),
               ib = along_row<b>(ab.inverse_face_width_, x[b] - ab.lo);
    const double *e = eps.data() + m, *ua = u[a].data() + m, *ub = u[b].data() + m;
    double* __restrict q = out.data() + (m - slab);
    for (int i = 0; i < n; ++i) {
      const double high = e[i - sa] + ha[i] * (e[i] - e[i - sa]);
      const double low = e[i - sa - sb] + ha[i] * (e[i - sb] - e[i - sa - sb]);
      q[i] = mu * (low + hb[i] * (high - low)) * ((ua[i] - ua[i - sb]) * ib[i] + (ub[i] - ub[i - sa]) * ia[i]);
    }
  }
}

/// out += the stresses' force on the volumes of component c in slab k.
template <int c>
inline void Momentum::add_stress(int k, Array3<double>& out) const {
  constexpr int a = (c + 1) % 3, b = (c + 2) % 3;  // shear_ of (c,a) is t = b; of (c,b) is t = a
  const Box& r = faces_[c];
  if (k < r.lo[2] || k >= r.hi[2]) return;
  const int n = r.size(0);
  const std::ptrdiff_t sy = out.stride(1), slab = out.index(local_.lo[0], local_.lo[1], k);
  for (int j = r.lo[1]; j < r.hi[1]; ++j) {
    const std::ptrdiff_t m = out.index(r.lo[0], j, k), q = m - slab;
    const Int3 x{r.lo[0], j, k};
    const auto wa = along_row<a>(axis_[a].width_, x[a] - axis_[a].lo),
               wb = along_row<b>(axis_[b].width_, x[b] - axis_[b].lo);
    const auto below = along_row<c>(axis_[c].half_below_, x[c] - axis_[c].lo),
               above = along_row<c>(axis_[c].half_above_, x[c] - axis_[c].lo);
    const double *nn = normal_[c].data() + q, *ca = shear_[b].data() + q, *cb = shear_[a].data() + q;
    // The stress a cell lower, and the next edges' in a and b.
    const double* under = c == 2 ? normal_below_.data() + q : nn - (c == 1 ? sy : 1);
    const double* ca_next = a == 2 ? shear_above_[b].data() + q : ca + (a == 1 ? sy : 1);
    const double* cb_next = b == 2 ? shear_above_[a].data() + q : cb + (b == 1 ? sy : 1);
    double* __restrict o = out.data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double sides = (ca_next[i] - ca[i]) * wb[i] + (cb_next[i] - cb[i]) * wa[i];
      o[i] += (nn[i] - under[i]) * wa[i] * wb[i] + sides * (below[i] + above[i]);
    }
  }
}

TWOGRID_VECTORISED void Momentum::viscous(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                                          FaceField<FineGrid>& out) {
  if (own_.empty()) return;
  const bool x = solved_[0], y = solved_[1], z = solved_[2];
  auto shear_at = [&](int k, Slab& yz, Slab& xz) {
    if (y && z) shear_stress<0>(mu, eps, u, k, yz);
    if (z && x) shear_stress<1>(mu, eps, u, k, xz);
  };
  if (z) normal_stresses(mu, eps, u, own_.lo[2] - 1);
  shear_at(own_.lo[2], shear_[0], shear_[1]);
  const int end = z ? faces_[2].hi[2] : own_.hi[2];
  for (int k = own_.lo[2]; k < end; ++k) {
    normal_[2].swap(normal_below_);
    normal_stresses(mu, eps, u, k);
    const bool inside = k < own_.hi[2];  // beyond them only the highest faces normal to z, at an outlet
    if (inside) shear_at(k + 1, shear_above_[0], shear_above_[1]);
    if (inside && x && y) shear_stress<2>(mu, eps, u, k, shear_[2]);
    if (inside && x) add_stress<0>(k, out[0]);
    if (inside && y) add_stress<1>(k, out[1]);
    if (z) add_stress<2>(k, out[2]);
    shear_[0].swap(shear_above_[0]), shear_[1].swap(shear_above_[1]);
  }
}

void Momentum::viscous_diagonal(double mu, const CellField<FineGrid>& eps, FaceField<FineGrid>& diagonal) const {
  if (own_.empty()) return;
  const std::array<std::ptrdiff_t, 3> s{eps.stride(0), eps.stride(1), eps.stride(2)};
  for (int c = 0; c < 3; ++c)
    for_each(faces_[c], [&](int i, int j, int k) {
      const Int3 x{i, j, k};
      const std::ptrdiff_t m = eps.index(i, j, k);
      const double mean = 0.5 * (eps.data()[m] + eps.data()[m - s[c]]);
      double sum = 4.0 / 3.0 * (1 / axis_[c].width(x[c] - 1) + 1 / axis_[c].width(x[c])) / axis_[c].face_width(x[c]);
      for (int d : {(c + 1) % 3, (c + 2) % 3})
        sum += (1 / axis_[d].face_width(x[d]) + 1 / axis_[d].face_width(x[d] + 1)) / axis_[d].width(x[d]);
      diagonal[c].data()[m] = mu * mean * sum * volume(c, i, j, k);
    });
}

}  // namespace twogrid
