#include "momentum.h"

#include <cmath>

namespace twogrid {

namespace {

/// Value transported through a side, from those below (v[lower]) and above it (v[lower + s]) and one more each way.
/// up, down: distances from the side to the values below and above; dist_*: those between neighbouring values.
inline double transported(const double* v, std::ptrdiff_t lower, std::ptrdiff_t s, double flow, bool limited, double up,
                          double down, double dist_below, double dist, double dist_above) {
  if (!limited) return v[lower] + (v[lower + s] - v[lower]) * (up / dist);
  const double slope = (v[lower + s] - v[lower]) / dist;
  if (flow >= 0) {
    const double behind = (v[lower] - v[lower - s]) / dist_below, p = slope * behind;
    return v[lower] + (p > 0 ? up * 2 * p / (slope + behind) : 0.0);
  }
  const double behind = (v[lower + 2 * s] - v[lower + s]) / dist_above, p = slope * behind;
  return v[lower + s] - (p > 0 ? down * 2 * p / (slope + behind) : 0.0);
}

/// The part of a velocity's change between two neighbouring faces that a void fraction explains which changes while
/// the flux F does not, F (1/e_hi - 1/e_lo): of the same sign as the whole change and no larger.
inline double explained(double change, double F, double e_lo, double e_hi) {
  const double by_eps = F * (e_lo - e_hi) / (e_lo * e_hi);
  if (!(change * by_eps > 0)) return 0;
  return std::abs(by_eps) < std::abs(change) ? by_eps : change;
}

/// Velocity transported along itself through a cell's centre, from the faces below (v[lower]) and above it, limited.
/// What the void fraction explains of a change is no front: it is taken centrally, the limiter sees the rest. Where F =
/// eps u is uniform the sum of u_f (u_c - u_c below) = (u_f^2)/2 then telescopes, so that eps grad p balances at any
/// jump of eps with no loss of head; a limited value would lose up to (jump of u)^2/2 there, on any grid. A uniform u
/// is kept whatever eps does, and the value lies between those of the two faces.
inline double transported_along(const double* v, const double* F, const double* e, std::ptrdiff_t lower,
                                std::ptrdiff_t s, double flow, double dist_below, double dist, double dist_above) {
  auto change = [&](std::ptrdiff_t at, double& by_eps) {
    const double all = v[at + s] - v[at];
    by_eps = explained(all, 0.5 * (F[at] + F[at + s]), e[at], e[at + s]);
    return all - by_eps;
  };
  double by_eps, by_eps_behind;
  const double slope = change(lower, by_eps) / dist;
  const bool up = flow >= 0;
  const double behind =
      up ? change(lower - s, by_eps_behind) / dist_below : change(lower + s, by_eps_behind) / dist_above;
  const double p = slope * behind;
  const double half = 0.5 * (by_eps + (p > 0 ? dist * 2 * p / (slope + behind) : 0.0));
  return up ? v[lower] + half : v[lower + s] - half;
}

}  // namespace

Momentum::Momentum(const FineGrid& grid, const Box& own, const Box& local, const std::array<Box, 3>& faces)
    : own_(own), local_(local), faces_(faces), periodic_(grid.periodic()), n_(grid.n()) {
  for (int d = 0; d < 3; ++d) {
    AxisMeasure& m = axis_[d];
    const Axis& a = grid.axis[d];
    m.lo = local.lo[d];
    for (int i = local.lo[d]; i < local.hi[d]; ++i) {
      m.width_.push_back(a.width(i));
      m.face_width_.push_back(a.face_width(i));
      const bool below_in = a.periodic() || i - 1 >= 0, above_in = a.periodic() || i < a.n();
      m.half_below_.push_back(below_in ? 0.5 * a.width(i - 1) : 0.0);
      m.half_above_.push_back(above_in ? 0.5 * a.width(i) : 0.0);
    }
  }
  flux_.reset(local);
  for (int d = 0; d < 3; ++d) normal_[d].reset(local), shear_[d].reset(local);
}

void Momentum::face_mean(const CellField<FineGrid>& eps, FaceField<FineGrid>& eps_f) const {
  if (own_.empty()) return;
  for (int c = 0; c < 3; ++c) {
    const std::ptrdiff_t s = eps.stride(c);
    const AxisMeasure& a = axis_[c];
    Box b = local_;
    ++b.lo[c];
    const double* e = eps.data();
    double* f = eps_f[c].data();
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        std::ptrdiff_t m = eps.index(b.lo[0], j, k);
        for (int i = b.lo[0]; i < b.hi[0]; ++i, ++m) {
          const int q = c == 0 ? i : c == 1 ? j : k;
          const double wl = a.width(q - 1), wr = a.width(q);
          f[m] = (e[m - s] * wl + e[m] * wr) / (wl + wr);
        }
      }
  }
}

template <int c, int d>
void Momentum::convect_part(double rho, const FaceField<FineGrid>& F, const FaceField<FineGrid>& eps_f,
                            const FaceComponent<FineGrid>& u, bool limited, FaceComponent<FineGrid>& out) {
  constexpr int e = c == d ? (c + 1) % 3 : 3 - c - d, f = (c + 2) % 3;  // transverse directions
  const std::ptrdiff_t sc = u.stride(c), sd = u.stride(d);
  const AxisMeasure &ac = axis_[c], &ad = axis_[d], &ae = axis_[e];
  const double* v = u.data();
  double* q = flux_.data();
  const double *Fd = F[d].data(), *eps = eps_f[d].data();
  // Where the flux stands: c == d: centre of cell m, between faces m and m+1; else: edge between volumes m-1 and m in
  // d.
  Box b = faces_[c];
  if (c == d)
    --b.lo[d];
  else
    ++b.hi[d];
  const bool bounded = !periodic_[d];
  const int last = n_[d];
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      std::ptrdiff_t m = u.index(b.lo[0], j, k);
      for (int i = b.lo[0]; i < b.hi[0]; ++i, ++m) {
        const Int3 x{i, j, k};
        double flow;           // m3/s through this side
        std::ptrdiff_t lower;  // index of the value below the side; the one above is lower + sd
        double dist, to_side_up, to_side_down, dist_below, dist_above;
        if (c == d) {
          flow = 0.5 * (Fd[m] + Fd[m + sc]) * ae.width(x[e]) * axis_[f].width(x[f]);
          lower = m;
          dist = ac.width(x[c]);
          to_side_up = to_side_down = 0.5 * dist;
          dist_below = x[c] - 1 >= local_.lo[c] ? ac.width(x[c] - 1) : dist;
          dist_above = x[c] + 1 < local_.hi[c] ? ac.width(x[c] + 1) : dist;
        } else {
          flow = (Fd[m - sc] * ac.half_below(x[c]) + Fd[m] * ac.half_above(x[c])) * ae.width(x[e]);
          lower = m - sd;
          dist = ad.face_width(x[d]);
          to_side_up = 0.5 * ad.width(x[d] - 1);
          to_side_down = 0.5 * ad.width(x[d]);
          dist_below = ad.face_width(x[d] - 1);
          dist_above = x[d] + 1 < local_.hi[d] ? ad.face_width(x[d] + 1) : dist;
        }
        double value;
        if (bounded && c != d && (x[d] == 0 || x[d] == last)) {
          value = 0.5 * (v[lower] + v[lower + sd]);  // the side's own value
        } else if (bounded && c == d && (x[d] < 0 || x[d] == last)) {
          // The outer side of an outlet's half volume is the outlet's face itself.
          const std::ptrdiff_t face = x[d] < 0 ? m + sc : m;
          flow = Fd[face] * ae.width(x[e]) * axis_[f].width(x[f]);
          value = v[face];
        } else if (c == d && limited) {
          value = transported_along(v, Fd, eps, lower, sd, flow, dist_below, dist, dist_above);
        } else {
          value = transported(v, lower, sd, flow, limited, to_side_up, to_side_down, dist_below, dist, dist_above);
        }
        q[m] = rho * flow * value;
      }
    }
  const Box& own = faces_[c];
  double* o = out.data();
  const std::ptrdiff_t below = c == d ? -sc : 0, above = c == d ? 0 : sd;
  for (int k = own.lo[2]; k < own.hi[2]; ++k)
    for (int j = own.lo[1]; j < own.hi[1]; ++j) {
      std::ptrdiff_t m = u.index(own.lo[0], j, k);
      for (int i = own.lo[0]; i < own.hi[0]; ++i, ++m) o[m] -= q[m + above] - q[m + below];
    }
}

void Momentum::convect(double rho, const FaceField<FineGrid>& F, const FaceField<FineGrid>& eps_f,
                       const FaceField<FineGrid>& u, Convection scheme, FaceField<FineGrid>& out) {
  if (scheme == Convection::kNone || own_.empty()) return;
  const bool limited = scheme == Convection::kVanLeer;
  convect_part<0, 0>(rho, F, eps_f, u[0], limited, out[0]);
  convect_part<0, 1>(rho, F, eps_f, u[0], limited, out[0]);
  convect_part<0, 2>(rho, F, eps_f, u[0], limited, out[0]);
  convect_part<1, 0>(rho, F, eps_f, u[1], limited, out[1]);
  convect_part<1, 1>(rho, F, eps_f, u[1], limited, out[1]);
  convect_part<1, 2>(rho, F, eps_f, u[1], limited, out[1]);
  convect_part<2, 0>(rho, F, eps_f, u[2], limited, out[2]);
  convect_part<2, 1>(rho, F, eps_f, u[2], limited, out[2]);
  convect_part<2, 2>(rho, F, eps_f, u[2], limited, out[2]);
}

double Momentum::convected_through(int c, int i, int j, int k, double rho, const FaceField<FineGrid>& F,
                                   const FaceField<FineGrid>& eps_f, const FaceField<FineGrid>& u,
                                   Convection scheme) const {
  if (scheme == Convection::kNone) return 0;
  const Int3 x{i, j, k};
  const std::ptrdiff_t s = u[c].stride(c), m = u[c].index(i, j, k);
  const AxisMeasure& a = axis_[c];
  const double flow = 0.5 * (F[c].data()[m] + F[c].data()[m + s]) * axis_[(c + 1) % 3].width(x[(c + 1) % 3]) *
                      axis_[(c + 2) % 3].width(x[(c + 2) % 3]);
  const double w = a.width(x[c]), below = a.width(x[c] - 1), above = a.width(x[c] + 1);
  const double* v = u[c].data();
  if (scheme == Convection::kVanLeer)
    return rho * flow * transported_along(v, F[c].data(), eps_f[c].data(), m, s, flow, below, w, above);
  return rho * flow * transported(v, m, s, flow, false, 0.5 * w, 0.5 * w, below, w, above);
}

void Momentum::viscous(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                       FaceField<FineGrid>& out) {
  if (own_.empty()) return;
  const double* e = eps.data();
  const std::array<std::ptrdiff_t, 3> s{eps.stride(0), eps.stride(1), eps.stride(2)};
  // Normal stresses in cells.
  {
    Box b = own_;
    for (int d = 0; d < 3; ++d) --b.lo[d], ++b.hi[d];
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        std::ptrdiff_t m = eps.index(b.lo[0], j, k);
        for (int i = b.lo[0]; i < b.hi[0]; ++i, ++m) {
          const double ux = (u[0].data()[m + s[0]] - u[0].data()[m]) / axis_[0].width(i);
          const double vy = (u[1].data()[m + s[1]] - u[1].data()[m]) / axis_[1].width(j);
          const double wz = (u[2].data()[m + s[2]] - u[2].data()[m]) / axis_[2].width(k);
          const double third = (ux + vy + wz) / 3, g = 2 * mu * e[m];
          normal_[0].data()[m] = g * (ux - third);
          normal_[1].data()[m] = g * (vy - third);
          normal_[2].data()[m] = g * (wz - third);
        }
      }
  }
  // Shear stresses on edges; edge m of directions (a,b) is the low corner of cell m in both.
  for (int t = 0; t < 3; ++t) {
    const int a = (t + 1) % 3, b = (t + 2) % 3;
    Box r = own_;
    for (int d = 0; d < 3; ++d) ++r.hi[d];
    const double *ua = u[a].data(), *ub = u[b].data();
    double* q = shear_[t].data();
    for (int k = r.lo[2]; k < r.hi[2]; ++k)
      for (int j = r.lo[1]; j < r.hi[1]; ++j) {
        std::ptrdiff_t m = eps.index(r.lo[0], j, k);
        for (int i = r.lo[0]; i < r.hi[0]; ++i, ++m) {
          const Int3 x{i, j, k};
          const double al = axis_[a].width(x[a] - 1), ar = axis_[a].width(x[a]);
          const double bl = axis_[b].width(x[b] - 1), br = axis_[b].width(x[b]);
          const double mean =
              (e[m] * ar * br + e[m - s[a]] * al * br + e[m - s[b]] * ar * bl + e[m - s[a] - s[b]] * al * bl) /
              ((al + ar) * (bl + br));
          q[m] =
              mu * mean *
              ((ua[m] - ua[m - s[b]]) / axis_[b].face_width(x[b]) + (ub[m] - ub[m - s[a]]) / axis_[a].face_width(x[a]));
        }
      }
  }
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;  // shear_ of (c,a) is t = b; of (c,b) is t = a
    const double *nn = normal_[c].data(), *ca = shear_[b].data(), *cb = shear_[a].data();
    double* o = out[c].data();
    const Box& own = faces_[c];
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        std::ptrdiff_t m = eps.index(own.lo[0], j, k);
        for (int i = own.lo[0]; i < own.hi[0]; ++i, ++m) {
          const Int3 x{i, j, k};
          const double wa = axis_[a].width(x[a]), wb = axis_[b].width(x[b]);
          const double wc = axis_[c].half_below(x[c]) + axis_[c].half_above(x[c]);
          o[m] += (nn[m] - nn[m - s[c]]) * wa * wb + ((ca[m + s[a]] - ca[m]) * wb + (cb[m + s[b]] - cb[m]) * wa) * wc;
        }
      }
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
