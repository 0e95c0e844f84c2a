// One level of the multigrid (multigrid.h): its operator, the way to the next coarser level, and the smoother.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/measures/open_rows.h"
#include "cfd/parallel/seven_point_halo.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

template <class T>
struct MultigridLevel {
  /// Inside a pair, a conductance counts as at least this share of the outer face's: where the pair is cut in two
  /// (contrast, an obstacle) the coarse grid stays connected.
  static constexpr double kLeastInner = 0.1;
  /// A cell's interpolation weights from coarse cells beside its own, summed over the directions, are at most this.
  static constexpr double kMostOuter = 1;

  Box own;
  Int3 n;
  std::array<bool, 3> periodic;
  std::vector<Box> all;  // of all ranks
  SevenPointHalo halo;
  bool odd_seam = false;       // an odd number of cells around a period: neighbours of one colour meet there
  std::array<Array3<T>, 3> g;  // of the low face
  Array3<T> dinv, x, b;
  std::unique_ptr<const OpenRows> open;  // parts of rows beyond which no cell has a conductance; null: whole rows
  // To the next level, by index of an own cell minus own.lo:
  std::array<std::vector<int>, 3> parent;  // its parent's global index
  std::array<std::vector<int>, 3> side;    // where the second parent of the interpolation lies: -1, 1, or 0: no second
  std::array<bool, 3> pair_below;          // the cell below own.lo has been merged with the one below it
  std::array<Array3<T>, 3> w;              // the second parent's weight
  std::vector<T> stripes;                  // 1, 0, 1, 0 ...: tells the colours of a row apart
  std::vector<T> row;                      // scratch, one value a cell of a row
  /// A row of own cells, as far as it is open.
  struct Row {
    int first, n, cell;              // memory index of its first cell, number, and that cell's index less own.lo
    int colour;                      // of the first cell
    int bare_begin, bare_end;        // of the cells, those that are not there to make groups whole
    int coarse = 0;                  // memory index of the coarse row's zeroth cell
    int beside_y = 0, beside_z = 0;  // from there to the rows of the second parents
  };
  std::vector<Row> rows;

  MultigridLevel(MPI_Comm comm, int rank, std::vector<Box> boxes, Int3 extent, std::array<bool, 3> wrap,
                 const Int3& width)
      : own(boxes[rank]), n(extent), periodic(wrap), all(std::move(boxes)), halo(comm, all, n, wrap, width) {
    for (int d = 0; d < 3; ++d) odd_seam = odd_seam || (wrap[d] && n[d] % 2 == 1 && n[d] > 1);
    const Box box = own.empty() ? Box{} : own.grown(width);
    for (auto& a : g) a.reset(box);
    dinv.reset(box);
    x.reset(box);
    b.reset(box);
    row.resize(own.size(0));
    for (int i = 0; i <= own.size(0); ++i) stripes.push_back(T(1 - i % 2));
  }

  /// A direction in which the only neighbour is the cell itself has no flux; after this dinv is 1 / sum of g.
  void finish_operator() {
    close_self_neighbours();
    invert_diagonal();
  }

  void close_self_neighbours() {
    for (int d = 0; d < 3; ++d)
      if (periodic[d] && n[d] == 1) g[d].fill(0);
  }

  /// Of a row of own cells, what is open.
  OpenRows::Part part(int j, int k) const { return open ? open->at(j, k) : OpenRows::Part{own.lo[0], own.hi[0]}; }

  TWOGRID_VECTORISED void invert_diagonal() {
    if (own.empty()) return;
    const T *gx = g[0].data(), *gy = g[1].data(), *gz = g[2].data();
    T* __restrict di = dinv.data();
    const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        const std::ptrdiff_t m0 = x.index(0, j, k);
        for (std::ptrdiff_t m = m0 + own.lo[0]; m < m0 + own.hi[0]; ++m) {
          const T sum = gx[m] + gx[m + 1] + gy[m] + gy[m + sy] + gz[m] + gz[m + sz];
          di[m] = (sum > 0 ? T(1) : T(0)) / (sum > 0 ? sum : T(1));
        }
      }
  }

  /// What stands for the conductance inside a pair, next to an outer face. The smallest number keeps 0/0 away.
  static T inner(T g, T face) { return std::max(g, T(kLeastInner) * face + std::numeric_limits<T>::min()); }

  /// coarse.g[d] += conductance between coarse centres along each fine line, which is also kept in w[d] at the face
  /// between the pairs.
  TWOGRID_VECTORISED void sum_conductances(int d, MultigridLevel& coarse) {
    const T* g_d = g[d].data();
    T *w_d = w[d].data(), *sum = coarse.g[d].data();
    const std::ptrdiff_t s = x.stride(d), high = coarse.x.stride(d);
    auto side_of = [&](int a) { return a < own.size(d) ? side[d][a] : 0; };
    // The line's resistance over the face's: the face, and half of the inner face of the pair on either side.
    auto line = [&](std::ptrdiff_t m, bool below, bool above) {
      const T face = g_d[m];
      T resistance = 1;
      if (below) resistance += T(0.5) * face / inner(g_d[m - s], face);
      if (above) resistance += T(0.5) * face / inner(g_d[m + s], face);
      w_d[m] = face / resistance;
    };
    Box faces = own;
    if (!periodic[d] && own.hi[d] == n[d]) ++faces.hi[d];
    for (int k = faces.lo[2]; k < faces.hi[2]; ++k)
      for (int j = faces.lo[1]; j < faces.hi[1]; ++j) {
        const std::ptrdiff_t m = x.index(own.lo[0], j, k);
        const int b = std::min(j, own.hi[1] - 1) - own.lo[1], c = std::min(k, own.hi[2] - 1) - own.lo[2];
        const OpenRows::Part p = part(own.lo[1] + b, own.lo[2] + c);
        const int first = p.begin - own.lo[0], n0 = p.end - own.lo[0];
        T* row = sum + coarse.x.index(0, parent[1][b], parent[2][c]);
        if (d == 0) {
          for (int i = first; i < std::min(n0 + 1, faces.size(0)); ++i) {
            if (side_of(i) == 1) continue;  // inside a pair
            line(m + i, i > 0 ? side[0][i - 1] == 1 : pair_below[0], side_of(i) == -1);
            row[i < own.size(0) ? parent[0][i] : parent[0][i - 1] + 1] += w_d[m + i];
          }
          continue;
        }
        const int a = d == 1 ? j - own.lo[1] : k - own.lo[2];
        if (side_of(a) == 1) continue;
        const bool below = a > 0 ? side[d][a - 1] == 1 : pair_below[d], above = side_of(a) == -1;
        if (below && above)
          for (int i = first; i < n0; ++i) line(m + i, true, true);
        else
          for (int i = first; i < n0; ++i) line(m + i, below, above);
        if (a == own.size(d)) row += high;
        for (int i = first; i < n0; ++i) row[parent[0][i]] += w_d[m + i];
      }
  }

  /// w[d], from the conductances that sum_conductances left there: the share of the way's resistance that lies inside
  /// the own pair. In place: the conductance of the face above is read before that place is overwritten.
  TWOGRID_VECTORISED void weigh(int d) {
    const T* g_d = g[d].data();
    T* w_d = w[d].data();
    const std::ptrdiff_t s = x.stride(d);
    const int n0 = own.size(0);
    auto share = [&](std::ptrdiff_t m, std::ptrdiff_t outer, std::ptrdiff_t in) {
      w_d[m] = T(0.5) * w_d[outer] / inner(g_d[in], g_d[outer]);
    };
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        const std::ptrdiff_t m = x.index(own.lo[0], j, k);
        if (d == 0) {
          for (int i = 0; i < n0; ++i) {
            if (side[0][i] == 0)
              w_d[m + i] = 0;
            else
              share(m + i, side[0][i] == 1 ? m + i + 1 : m + i, side[0][i] == 1 ? m + i : m + i + 1);
          }
          continue;
        }
        const int where = d == 1 ? side[1][j - own.lo[1]] : side[2][k - own.lo[2]];
        if (where == 0)
          std::fill_n(w_d + m, n0, T(0));
        else if (where == -1)
          for (int i = 0; i < n0; ++i) share(m + i, m + i, m + i + s);
        else
          for (int i = 0; i < n0; ++i) share(m + i, m + i + s, m + i);
      }
  }

  TWOGRID_VECTORISED void limit_weights() {
    T *wx = w[0].data(), *wy = w[1].data(), *wz = w[2].data();
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        const std::ptrdiff_t begin = x.index(own.lo[0], j, k);
        for (std::ptrdiff_t m = begin; m < begin + own.size(0); ++m) {
          const T factor = T(kMostOuter) / std::max(T(kMostOuter), wx[m] + wy[m] + wz[m]);
          wx[m] *= factor, wy[m] *= factor, wz[m] *= factor;
        }
      }
  }

  /// Once all that belongs to the levels is there. coarse: the next level; null on the last.
  void list_rows(const MultigridLevel* coarse) {
    if (own.empty()) return;
    const OpenRows::Part all{own.lo[0], own.hi[0]};
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        const OpenRows::Part p = open ? open->at(j, k) : all, bare = open ? open->bare(j, k) : all;
        if (bare.size() == 0) continue;
        Row r;
        r.first = int(x.index(p.begin, j, k)), r.n = p.size();
        r.colour = (p.begin + j + k) & 1;
        r.bare_begin = bare.begin - p.begin, r.bare_end = bare.end - p.begin;
        r.cell = p.begin - own.lo[0];
        if (coarse) {
          const int b = j - own.lo[1], c = k - own.lo[2];
          r.coarse = int(coarse->x.index(0, parent[1][b], parent[2][c]));
          r.beside_y = int(side[1][b] * coarse->x.stride(1)), r.beside_z = int(side[2][c] * coarse->x.stride(2));
        }
        rows.push_back(r);
      }
  }

  /// Calls f(row, 0 if the row's first cell has the colour, else 1) for each row of own cells, as far as it is open.
  template <class F>
  void for_each_row(int colour, F&& f) const {
    for (const Row& r : rows) f(r, (r.colour + colour) & 1);
  }
  /// The row's first cell of those of a colour that count.
  static int first_of(const Row& r, int other) { return r.bare_begin + ((r.bare_begin + other) & 1); }

  /// x = b / diagonal: a Gauss-Seidel half sweep that starts from zero. Of both colours: that of the other is
  /// overwritten unread by the half sweep that follows, but for those across an odd seam, which are cleared.
  TWOGRID_VECTORISED void start(int colour) {
    const bool one = odd_seam;
    for_each_row(colour, [&](const Row& w, int other) {
      const T *di = dinv.data() + w.first, *bb = b.data() + w.first;
      T* __restrict xx = x.data() + w.first;
      for (int i = 0; i < w.n; ++i) xx[i] = di[i] * bb[i];
      if (!one) return;
      const T* mine = stripes.data() + other;
      for (int i = 0; i < w.n; ++i) xx[i] *= mine[i];
    });
  }

  /// Whole rows are computed, which vectorises, and one colour is kept: its cells have neighbours of the other alone.
  TWOGRID_VECTORISED void smooth(int colour) {
    const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
    for_each_row(colour, [&](const Row& w, int other) {
      const std::ptrdiff_t m = w.first;
      const T *gx = g[0].data() + m, *gy = g[1].data() + m, *gz = g[2].data() + m, *di = dinv.data() + m,
              *bb = b.data() + m, *mine = stripes.data() + other;
      const T* xx = x.data() + m;
      T* to = x.data() + m;
      asm("" : "+r"(to));  // else the compiler would see one array, and keep the order of reads and writes
#pragma GCC ivdep
      for (int i = 0; i < w.n; ++i) {
        const T found = di[i] * (bb[i] + ((gx[i] * xx[i - 1] + gx[i + 1] * xx[i + 1]) +
                                          (gy[i] * xx[i - sy] + gy[i + sy] * xx[i + sy]) +
                                          (gz[i] * xx[i - sz] + gz[i + sz] * xx[i + sz])));
        to[i] = mine[i] != 0 ? found : xx[i];
      }
    });
  }

  /// coarse.b += P^T (b - A x), of the cells of one colour; contributions to other ranks' cells stay in coarse.b's
  /// halo.
  TWOGRID_VECTORISED void restrict_residual(int colour, MultigridLevel& coarse) {
    const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
    T* __restrict r = row.data();
    T* cb = coarse.b.data();
    for_each_row(colour, [&](const Row& row_of, int other) {
      const std::ptrdiff_t m = row_of.first;
      const int nx = row_of.n;
      const T *gx = g[0].data() + m, *gy = g[1].data() + m, *gz = g[2].data() + m, *bb = b.data() + m,
              *xx = x.data() + m;
#pragma GCC ivdep
      for (int i = 0; i < nx; ++i) {
        const T c = xx[i];
        r[i] = bb[i] + ((gx[i] * (xx[i - 1] - c) + gx[i + 1] * (xx[i + 1] - c)) +
                        (gy[i] * (xx[i - sy] - c) + gy[i + sy] * (xx[i + sy] - c)) +
                        (gz[i] * (xx[i - sz] - c) + gz[i + sz] * (xx[i + sz] - c)));
      }
      const T *wx = w[0].data() + m, *wy = w[1].data() + m, *wz = w[2].data() + m;
      const int *to = parent[0].data() + row_of.cell, *beside = side[0].data() + row_of.cell;
      T* row_b = cb + row_of.coarse;
      const std::ptrdiff_t oy = row_of.beside_y, oz = row_of.beside_z;
      for (int i = first_of(row_of, other); i < row_of.bare_end; i += 2) {
        T* p = row_b + to[i];
        const T rx = wx[i] * r[i], ry = wy[i] * r[i], rz = wz[i] * r[i];
        *p += r[i] - (rx + ry + rz);
        p[beside[i]] += rx;
        p[oy] += ry;
        p[oz] += rz;
      }
    });
  }

  /// x += P coarse.x on the cells of one colour.
  TWOGRID_VECTORISED void prolong(int colour, const MultigridLevel& coarse) {
    for_each_row(colour, [&](const Row& row_of, int other) {
      const std::ptrdiff_t m = row_of.first, oy = row_of.beside_y, oz = row_of.beside_z;
      const T* row_x = coarse.x.data() + row_of.coarse;
      const T *wx = w[0].data() + m, *wy = w[1].data() + m, *wz = w[2].data() + m;
      const int *from = parent[0].data() + row_of.cell, *beside = side[0].data() + row_of.cell;
      T* xx = x.data() + m;
      for (int i = first_of(row_of, other); i < row_of.bare_end; i += 2) {
        const T *p = row_x + from[i], c = *p;
        xx[i] += c + ((wx[i] * (p[beside[i]] - c) + wy[i] * (p[oy] - c)) + wz[i] * (p[oz] - c));
      }
    });
  }
};

}  // namespace twogrid
