#include "cfd/momentum/viscous_stress.h"

#include <algorithm>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

ViscousTerm::ViscousTerm(const GridMeasures& measures, const Box& own, const Box& local,
                         const std::array<Box, 3>& faces, const std::array<bool, 3>& solved)
    : measures_(measures),
      own_(own),
      local_(local),
      faces_(faces),
      solved_(solved),
      axis_{measures.axis(0), measures.axis(1), measures.axis(2)} {
  const std::size_t slab = std::size_t(local.size(0)) * local.size(1);
  if (measures.open() && measures.open()->has_links()) {
    cut_ = std::make_unique<CutLinks>(measures, faces, solved);
    if (!own.empty()) list_rows(*measures.open());
  }
  for (auto* s : {&normal_[0], &normal_[1], &normal_[2], &normal_below_, &shear_[0], &shear_[1], &shear_[2],
                  &shear_above_[0], &shear_above_[1]}) {
    s->value.assign(slab, 0.0);
    if (cut_) s->part.assign(local.size(1), {0, 0});
  }
}

/// Parts of rows where the stresses are not left out, and of the faces beside them, which are open all of them.
void ViscousTerm::list_rows(const OpenShares& open) {
  Box cells = own_, edges = own_;
  for (int d = 0; d < 3; ++d) {
    if (local_.size(d) == own_.size(d)) continue;
    --cells.lo[d], ++cells.hi[d], ++edges.hi[d];
  }
  stressed_cells_ = OpenRows(cells, OpenRows::kDoubles, [&](int i, int j, int k) { return open.cell()(i, j, k) != 0; });
  for (int t = 0; t < 3; ++t)
    if (solved_[(t + 1) % 3] && solved_[(t + 2) % 3])
      stressed_edges_[t] =
          OpenRows(edges, OpenRows::kDoubles, [&](int i, int j, int k) { return open.edge(t)(i, j, k) != 0; });
  for (int c = 0; c < 3; ++c)
    if (solved_[c])
      stressed_faces_[c] = OpenRows(faces_[c], OpenRows::kDoubles, [&](int i, int j, int k) {
        const std::ptrdiff_t m = open.cell().index(i, j, k);
        bool any = open.cell().data()[m] != 0 || open.cell().data()[m - open.cell().stride(c)] != 0;
        for (int d = 0; d < 3; ++d)
          if (d != c && solved_[d]) {
            const double* edge = open.edge(3 - c - d).data() + m;
            any = any || edge[0] != 0 || edge[open.cell().stride(d)] != 0;
          }
        return any;
      });
}

/// The part of row j that will be written, which the slabs take as theirs: zero outside it.
inline OpenRows::Part ViscousTerm::take_part(const OpenRows& rows, int j, int k,
                                             std::initializer_list<Slab*> slabs) const {
  const OpenRows::Part p = rows.at(j, k);
  for (Slab* s : slabs) {
    OpenRows::Part& before = s->part[j - local_.lo[1]];
    if (before.begin == p.begin && before.end == p.end) continue;
    std::fill_n(s->data() + std::ptrdiff_t(local_.size(0)) * (j - local_.lo[1]), local_.size(0), 0.0);
    before = p;
  }
  return p;
}

/// mu in cell m, on its low edge normal to two directions (strides sa, sb; shares of the upper cells ha, hb), on its low
/// face.
struct ViscousTerm::Uniform {
  double mu;
  double in_cell(std::ptrdiff_t) const { return mu; }
  double on_edge(std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t, double, double) const { return mu; }
  double on_face(std::ptrdiff_t, std::ptrdiff_t) const { return mu; }
};
struct ViscousTerm::Varying {
  const double* mu;
  double in_cell(std::ptrdiff_t m) const { return mu[m]; }
  double on_edge(std::ptrdiff_t m, std::ptrdiff_t sa, std::ptrdiff_t sb, double ha, double hb) const {
    const double high = (1 - ha) / mu[m - sa] + ha / mu[m], low = (1 - ha) / mu[m - sa - sb] + ha / mu[m - sb];
    return 1 / ((1 - hb) * low + hb * high);
  }
  double on_face(std::ptrdiff_t m, std::ptrdiff_t s) const { return 0.5 * (mu[m] + mu[m - s]); }
};

/// Normal stresses in slab k of own cells, and of one more around where a direction is not left out.
template <bool whole, class Mu>
inline void ViscousTerm::normal_stresses(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                                         int k) {
  const int around = local_.size(1) > own_.size(1) ? 1 : 0;
  int first = own_.lo[0] - 1, n = own_.size(0) + 2;
  const std::ptrdiff_t sy = eps.stride(1), sz = eps.stride(2), slab = eps.index(local_.lo[0], local_.lo[1], k);
  for (int j = own_.lo[1] - around; j < own_.hi[1] + around; ++j) {
    if (!whole) {
      const OpenRows::Part p = take_part(stressed_cells_, j, k, {&normal_[0], &normal_[1], &normal_[2]});
      if (p.size() == 0) continue;
      first = p.begin, n = p.size();
    }
    const double* ix = &axis_[0].inverse_width_[first - axis_[0].lo];
    const std::ptrdiff_t m = eps.index(first, j, k);
    const double iy = axis_[1].inverse_width_[j - axis_[1].lo], iz = axis_[2].inverse_width_[k - axis_[2].lo];
    const double *e = eps.data() + m, *ux = u[0].data() + m, *uy = u[1].data() + m, *uz = u[2].data() + m;
    double *__restrict nx = normal_[0].data() + (m - slab), *__restrict ny = normal_[1].data() + (m - slab),
                       *__restrict nz = normal_[2].data() + (m - slab);
    const double* share = whole ? nullptr : measures_.open()->cell().data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x = (ux[i + 1] - ux[i]) * ix[i], y = (uy[i + sy] - uy[i]) * iy, z = (uz[i + sz] - uz[i]) * iz;
      const double third = (x + y + z) * (1.0 / 3), g = 2 * mu.in_cell(m + i) * e[i];
      const double s = whole ? 1.0 : share[i];
      nx[i] = whole ? g * (x - third) : g * (x - third) * s;
      ny[i] = whole ? g * (y - third) : g * (y - third) * s;
      nz[i] = whole ? g * (z - third) : g * (z - third) * s;
    }
  }
}

/// Shear stresses of the two directions other than t on edges; edge m is the low corner of cell m in both.
template <int t, bool whole, class Mu>
inline void ViscousTerm::shear_stress(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k,
                                      Slab& out) const {
  constexpr int a = (t + 1) % 3, b = (t + 2) % 3;
  const AxisMeasure &aa = axis_[a], &ab = axis_[b];
  const int around = local_.size(1) > own_.size(1) ? 1 : 0;
  int first = own_.lo[0], n = own_.size(0) + 1;
  const OpenShares* open = measures_.open();
  const std::ptrdiff_t sa = eps.stride(a), sb = eps.stride(b), slab = eps.index(local_.lo[0], local_.lo[1], k);
  for (int j = own_.lo[1]; j < own_.hi[1] + around; ++j) {
    if (!whole) {
      const OpenRows::Part p = take_part(stressed_edges_[t], j, k, {&out});
      if (p.size() == 0) continue;
      first = p.begin, n = p.size();
    }
    const std::ptrdiff_t m = eps.index(first, j, k);
    const Int3 x{first, j, k};
    const auto ha = along_row<a>(aa.above_share_, x[a] - aa.lo);
    const auto hb = along_row<b>(ab.above_share_, x[b] - ab.lo);
    const auto ia = along_row<a>(aa.inverse_face_width_, x[a] - aa.lo);
    const auto ib = along_row<b>(ab.inverse_face_width_, x[b] - ab.lo);
    const double *e = eps.data() + m, *ua = u[a].data() + m, *ub = u[b].data() + m;
    const double* share = open ? open->edge(t).data() + m : nullptr;
    double* __restrict q = out.data() + (m - slab);
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double high = e[i - sa] + ha[i] * (e[i] - e[i - sa]);
      const double low = e[i - sa - sb] + ha[i] * (e[i - sb] - e[i - sa - sb]);
      const double stress = mu.on_edge(m + i, sa, sb, ha[i], hb[i]) * (low + hb[i] * (high - low)) *
                            ((ua[i] - ua[i - sb]) * ib[i] + (ub[i] - ub[i - sa]) * ia[i]);
      q[i] = whole ? stress : stress * share[i];
    }
    if (!whole || !open) continue;
    for (int i = 0; i < n; ++i) q[i] *= share[i];
  }
}

/// out += the stresses' force on the volumes of component c in slab k.
template <int c, bool whole>
inline void ViscousTerm::add_stress(int k, Array3<double>& out) const {
  constexpr int a = (c + 1) % 3, b = (c + 2) % 3;  // shear_ of (c,a) is t = b; of (c,b) is t = a
  const Box& r = faces_[c];
  if (k < r.lo[2] || k >= r.hi[2]) return;
  int first = r.lo[0], n = r.size(0);
  const std::ptrdiff_t sy = out.stride(1), slab = out.index(local_.lo[0], local_.lo[1], k);
  for (int j = r.lo[1]; j < r.hi[1]; ++j) {
    if (!whole) {
      const OpenRows::Part p = stressed_faces_[c].at(j, k);
      if (p.size() == 0) continue;
      first = p.begin, n = p.size();
    }
    const std::ptrdiff_t m = out.index(first, j, k), q = m - slab;
    const Int3 x{first, j, k};
    const auto wa = along_row<a>(axis_[a].width_, x[a] - axis_[a].lo);
    const auto wb = along_row<b>(axis_[b].width_, x[b] - axis_[b].lo);
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

template <bool whole, class Mu>
inline void ViscousTerm::add_with(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                                  FaceField<FineGrid>& out) {
  if (own_.empty()) return;
  const bool x = solved_[0], y = solved_[1], z = solved_[2];
  auto shear_at = [&](int k, Slab& yz, Slab& xz) {
    if (y && z) shear_stress<0, whole>(mu, eps, u, k, yz);
    if (z && x) shear_stress<1, whole>(mu, eps, u, k, xz);
  };
  if (z) normal_stresses<whole>(mu, eps, u, own_.lo[2] - 1);
  shear_at(own_.lo[2], shear_[0], shear_[1]);
  const int end = z ? faces_[2].hi[2] : own_.hi[2];
  for (int k = own_.lo[2]; k < end; ++k) {
    normal_[2].swap(normal_below_);
    normal_stresses<whole>(mu, eps, u, k);
    const bool inside = k < own_.hi[2];  // beyond them only the highest faces normal to z, at an outlet
    if (inside) shear_at(k + 1, shear_above_[0], shear_above_[1]);
    if (inside && x && y) shear_stress<2, whole>(mu, eps, u, k, shear_[2]);
    if (inside && x) add_stress<0, whole>(k, out[0]);
    if (inside && y) add_stress<1, whole>(k, out[1]);
    if (z) add_stress<2, whole>(k, out[2]);
    shear_[0].swap(shear_above_[0]), shear_[1].swap(shear_above_[1]);
  }
}

TWOGRID_VECTORISED void ViscousTerm::add_uniform(double mu, const CellField<FineGrid>& eps,
                                                 const FaceField<FineGrid>& u, FaceField<FineGrid>& out) {
  add_with<true>(Uniform{mu}, eps, u, out);
}

TWOGRID_VECTORISED void ViscousTerm::add_varying(const CellField<FineGrid>& mu, const CellField<FineGrid>& eps,
                                                 const FaceField<FineGrid>& u, FaceField<FineGrid>& out) {
  add_with<true>(Varying{mu.data()}, eps, u, out);
}

TWOGRID_VECTORISED void ViscousTerm::add_uniform_between_bodies(double mu, const CellField<FineGrid>& eps,
                                                                const FaceField<FineGrid>& u,
                                                                FaceField<FineGrid>& out) {
  add_with<false>(Uniform{mu}, eps, u, out);
}

TWOGRID_VECTORISED void ViscousTerm::add_varying_between_bodies(const CellField<FineGrid>& mu,
                                                                const CellField<FineGrid>& eps,
                                                                const FaceField<FineGrid>& u,
                                                                FaceField<FineGrid>& out) {
  add_with<false>(Varying{mu.data()}, eps, u, out);
}

void ViscousTerm::add(const Property& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                      FaceField<FineGrid>& out) {
  if (mu.varies())
    cut_ ? add_varying_between_bodies(mu.field(), eps, u, out) : add_varying(mu.field(), eps, u, out);
  else
    cut_ ? add_uniform_between_bodies(mu.number, eps, u, out) : add_uniform(mu.number, eps, u, out);
  if (cut_) cut_->add(mu, eps, u, out);
}

/// Of the diagonal over the face's volume and mu eps: the part of stresses that are left out beside a body.
double ViscousTerm::cut_share(int c, const Int3& x, std::ptrdiff_t m) const {
  const OpenShares& open = *measures_.open();
  double sum = 0;
  for (bool up : {false, true}) {
    if (open.cell().data()[up ? m : m - open.cell().stride(c)] == 0)
      sum += 4.0 / 3.0 / axis_[c].width(x[c] - !up) / axis_[c].face_width(x[c]);
    for (int d : {(c + 1) % 3, (c + 2) % 3})
      if (open.edge(3 - c - d).data()[up ? m + open.cell().stride(d) : m] == 0)
        sum += 1 / axis_[d].face_width(x[d] + up) / axis_[d].width(x[d]);
  }
  return sum;
}

template <class Mu>
inline void ViscousTerm::diagonal_with(const Mu& mu, const CellField<FineGrid>& eps,
                                       FaceField<FineGrid>& diagonal) const {
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
      if (cut_) sum -= cut_share(c, x, m);
      diagonal[c].data()[m] = mu.on_face(m, s[c]) * mean * sum * measures_.volume(c, i, j, k);
    });
}

void ViscousTerm::diagonal(const Property& mu, const CellField<FineGrid>& eps, FaceField<FineGrid>& diagonal) const {
  if (mu.varies())
    diagonal_with(Varying{mu.field().data()}, eps, diagonal);
  else
    diagonal_with(Uniform{mu.number}, eps, diagonal);
  if (cut_) cut_->add_diagonal(mu, eps, diagonal);
}

}  // namespace twogrid
