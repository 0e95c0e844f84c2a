#include "cfd/pressure/multigrid.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// One direction of a level: nodes, and where bricks begin and end.
struct Line {
  std::vector<double> node;
  std::vector<int> cut;

  int n() const { return int(node.size()) - 1; }
  /// Between the centres of cells i and i + 1.
  double distance(int i) const { return 0.5 * (node[i + 2] - node[i]); }
};

/// Parent of each cell when neighbours of one brick are merged in pairs up to a distance.
std::vector<int> merge(const Line& line, double distance) {
  std::vector<int> parent(line.n());
  int next = 0;
  for (std::size_t c = 0; c + 1 < line.cut.size(); ++c)
    for (int i = line.cut[c]; i < line.cut[c + 1]; ++i, ++next) {
      parent[i] = next;
      if (i + 1 < line.cut[c + 1] && line.distance(i) <= distance) parent[++i] = next;
    }
  return parent;
}

/// Smallest distance of two neighbours of one brick; infinite if no brick has two cells.
double closest(const Line& line) {
  double d = INFINITY;
  for (std::size_t c = 0; c + 1 < line.cut.size(); ++c)
    for (int i = line.cut[c]; i + 1 < line.cut[c + 1]; ++i) d = std::min(d, line.distance(i));
  return d;
}

Line coarse_line(const Line& fine, const std::vector<int>& parent) {
  Line coarse;
  for (int i = 0; i < fine.n(); ++i)
    if (i == 0 || parent[i] != parent[i - 1]) coarse.node.push_back(fine.node[i]);
  coarse.node.push_back(fine.node.back());
  for (int c : fine.cut) coarse.cut.push_back(c == fine.n() ? coarse.n() : parent[c]);
  return coarse;
}

using Lines = std::array<Line, 3>;
using Parents = std::array<std::vector<int>, 3>;

/// The pairs of the next level, or empty lists when no two cells may be merged.
Parents choose_pairs(const Lines& lines, double stretch, double shrink) {
  double distance = INFINITY;
  for (const Line& line : lines) distance = std::min(distance, closest(line));
  if (!std::isfinite(distance)) return {};
  distance *= stretch;
  double longest = 0;
  for (const Line& line : lines) longest = std::max(longest, line.node.back() - line.node.front());
  for (;; distance *= 1.25) {
    Parents parents;
    double left = 1;
    for (int d = 0; d < 3; ++d) {
      parents[d] = merge(lines[d], distance);
      left *= (parents[d].back() + 1.0) / lines[d].n();
    }
    if (left <= shrink || distance > longest) return parents;
  }
}

}  // namespace

template <class T>
struct Multigrid<T>::Level {
  Box own;
  Int3 n;
  std::array<bool, 3> periodic;
  std::vector<Box> all;  // of all ranks
  SevenPointHalo halo;
  bool odd_seam = false;       // an odd number of cells around a period: neighbours of one colour meet there
  std::array<Array3<T>, 3> g;  // of the low face
  Array3<T> dinv, x, b;
  // To the next level, by index of an own cell minus own.lo:
  std::array<std::vector<int>, 3> parent;  // its parent's global index
  std::array<std::vector<int>, 3> side;    // where the second parent of the interpolation lies: -1, 1, or 0: no second
  std::array<bool, 3> pair_below;          // the cell below own.lo has been merged with the one below it
  std::array<Array3<T>, 3> w;              // the second parent's weight
  std::vector<T> stripes;                  // 1, 0, 1, 0 ...: tells the colours of a row apart
  std::vector<T> row;                      // scratch, one value a cell of a row

  Level(MPI_Comm comm, int rank, std::vector<Box> boxes, Int3 extent, std::array<bool, 3> wrap, const Int3& width)
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
  TWOGRID_VECTORISED void sum_conductances(int d, Level& coarse) {
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
    const int n0 = faces.size(0);
    for (int k = faces.lo[2]; k < faces.hi[2]; ++k)
      for (int j = faces.lo[1]; j < faces.hi[1]; ++j) {
        const std::ptrdiff_t m = x.index(own.lo[0], j, k);
        const int b = std::min(j, own.hi[1] - 1) - own.lo[1], c = std::min(k, own.hi[2] - 1) - own.lo[2];
        T* row = sum + coarse.x.index(0, parent[1][b], parent[2][c]);
        if (d == 0) {
          for (int i = 0; i < n0; ++i) {
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
          for (int i = 0; i < n0; ++i) line(m + i, true, true);
        else
          for (int i = 0; i < n0; ++i) line(m + i, below, above);
        if (a == own.size(d)) row += high;
        for (int i = 0; i < n0; ++i) row[parent[0][i]] += w_d[m + i];
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

  /// Calls f(j, k, memory index of the row's first own cell, stripes of the colour) for each row of own cells.
  template <class F>
  void whole_rows(int colour, F&& f) const {
    if (own.empty()) return;  // else, with no cell in x, f would look for the colour of a row's first cell
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j)
        f(j, k, x.index(own.lo[0], j, k), stripes.data() + ((own.lo[0] + j + k + colour) & 1));
  }

  /// x = b / diagonal: a Gauss-Seidel half sweep that starts from zero. Of both colours: that of the other is
  /// overwritten unread by the half sweep that follows, but for those across an odd seam, which are cleared.
  TWOGRID_VECTORISED void start(int colour) {
    const int nx = own.size(0);
    const bool one = odd_seam;
    whole_rows(colour, [&](int, int, std::ptrdiff_t m, const T* mine) {
      const T *di = dinv.data() + m, *bb = b.data() + m;
      T* __restrict xx = x.data() + m;
      for (int i = 0; i < nx; ++i) xx[i] = di[i] * bb[i];
      if (one)
        for (int i = 0; i < nx; ++i) xx[i] *= mine[i];
    });
  }

  /// Whole rows are computed, which vectorises, and one colour is kept.
  TWOGRID_VECTORISED void smooth(int colour) {
    const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
    const int nx = own.size(0);
    T* __restrict found = row.data();
    whole_rows(colour, [&](int, int, std::ptrdiff_t m, const T* mine) {
      const T *gx = g[0].data() + m, *gy = g[1].data() + m, *gz = g[2].data() + m, *di = dinv.data() + m,
              *bb = b.data() + m;
      T* xx = x.data() + m;
#pragma GCC ivdep
      for (int i = 0; i < nx; ++i)
        found[i] = di[i] * (bb[i] + ((gx[i] * xx[i - 1] + gx[i + 1] * xx[i + 1]) +
                                     (gy[i] * xx[i - sy] + gy[i + sy] * xx[i + sy]) +
                                     (gz[i] * xx[i - sz] + gz[i + sz] * xx[i + sz])));
      for (int i = 0; i < nx; ++i) xx[i] = mine[i] != 0 ? found[i] : xx[i];
    });
  }

  /// coarse.b += P^T (b - A x), of the cells of one colour; contributions to other ranks' cells stay in coarse.b's
  /// halo.
  TWOGRID_VECTORISED void restrict_residual(int colour, Level& coarse) {
    const std::ptrdiff_t sy = x.stride(1), sz = x.stride(2);
    const int nx = own.size(0);
    T* __restrict r = row.data();
    T* cb = coarse.b.data();
    whole_rows(colour, [&](int j, int k, std::ptrdiff_t m, const T* mine) {
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
      const int *to = parent[0].data(), *beside = side[0].data();
      T* row_b = cb + coarse.b.index(0, parent[1][j - own.lo[1]], parent[2][k - own.lo[2]]);
      const std::ptrdiff_t oy = side[1][j - own.lo[1]] * coarse.b.stride(1),
                           oz = side[2][k - own.lo[2]] * coarse.b.stride(2);
      for (int i = mine[0] != 0 ? 0 : 1; i < nx; i += 2) {
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
  TWOGRID_VECTORISED void prolong(int colour, const Level& coarse) {
    const int nx = own.size(0);
    whole_rows(colour, [&](int j, int k, std::ptrdiff_t m, const T* mine) {
      const T* row_x = coarse.x.data() + coarse.x.index(0, parent[1][j - own.lo[1]], parent[2][k - own.lo[2]]);
      const std::ptrdiff_t oy = side[1][j - own.lo[1]] * coarse.x.stride(1),
                           oz = side[2][k - own.lo[2]] * coarse.x.stride(2);
      const T *wx = w[0].data() + m, *wy = w[1].data() + m, *wz = w[2].data() + m;
      const int *from = parent[0].data(), *beside = side[0].data();
      T* xx = x.data() + m;
      for (int i = mine[0] != 0 ? 0 : 1; i < nx; i += 2) {
        const T *p = row_x + from[i], c = *p;
        xx[i] += c + ((wx[i] * (p[beside[i]] - c) + wy[i] * (p[oy] - c)) + wz[i] * (p[oz] - c));
      }
    });
  }
};

/// The smallest level, gathered on every rank and solved by a sparse LDL^T there. A diagonal raised by 1e-10 keeps it
/// definite where cells are cut off from all boundaries; where the whole grid is (singular), means are taken out.
template <class T>
class Multigrid<T>::Coarsest {
 public:
  Coarsest(MPI_Comm comm, const Level& level) : comm_(comm) {
    int ranks = 0;
    MPI_Comm_size(comm, &ranks);
    Array3<int> number(Box{{0, 0, 0}, level.n}, 0);
    for (const Box& box : level.all) {
      first_.push_back(total_);
      count_.push_back(int(box.count()));
      for_each(box, [&](int i, int j, int k) { number(i, j, k) = total_++; });
    }
    for (const Box& box : level.all)
      for_each(box, [&](int i, int j, int k) {
        Int3 c{i, j, k};
        for (int d = 0; d < 3; ++d) {
          Int3 low = c;
          low[d] = c[d] > 0 ? c[d] - 1 : level.periodic[d] ? level.n[d] - 1 : -1;
          neighbour_.push_back(low[d] < 0 || low == c ? -1 : number(low[0], low[1], low[2]));
        }
      });
    MPI_Comm_rank(comm, &rank_);
    mine_.resize(4 * count_[rank_]);
    all_.resize(4 * total_);
    for (int r = 0; r < ranks; ++r) first4_.push_back(4 * first_[r]), count4_.push_back(4 * count_[r]);
    entry_.reserve(7 * total_);
    matrix_.resize(total_, total_);
    rhs_.resize(total_);
    solution_.resize(total_);
  }

  void set_operator(const Level& l, bool singular) {
    singular_ = singular;
    double* out = mine_.data();
    for_each(l.own, [&](int i, int j, int k) {
      for (int d = 0; d < 3; ++d) *out++ = double(l.g[d](i, j, k));
      double sum = 0;
      for (int d = 0; d < 3; ++d)
        sum += double(l.g[d](i, j, k)) + double(l.g[d].data()[l.g[d].index(i, j, k) + l.g[d].stride(d)]);
      *out++ = sum;
    });
    gather(mine_.data(), count4_, first4_, all_.data());
    double scale = 0;
    for (int c = 0; c < total_; ++c) scale = std::max(scale, all_[4 * c + 3]);
    if (scale == 0) scale = 1;
    entry_.clear();
    for (int c = 0; c < total_; ++c) {
      const double* g = &all_[4 * c];
      entry_.emplace_back(c, c, g[3] * (1 + 1e-10) + 1e-14 * scale);
      for (int d = 0; d < 3; ++d) {
        const int nb = neighbour_[3 * c + d];
        if (nb < 0) continue;
        entry_.emplace_back(std::max(c, nb), std::min(c, nb), -g[d]);
      }
    }
    matrix_.setFromTriplets(entry_.begin(), entry_.end());
    if (!analysed_) factor_.analyzePattern(matrix_), analysed_ = true;
    factor_.factorize(matrix_);
  }

  void solve(Level& l) {
    double* out = mine_.data();
    for_each(l.own, [&](int i, int j, int k) { *out++ = double(l.b(i, j, k)); });
    gather(mine_.data(), count_, first_, rhs_.data());
    if (singular_) rhs_.array() -= rhs_.mean();
    solution_ = factor_.solve(rhs_);
    if (singular_) solution_.array() -= solution_.mean();
    int m = first_[rank_];
    for_each(l.own, [&](int i, int j, int k) { l.x(i, j, k) = T(solution_[m++]); });
  }

 private:
  void gather(const double* own, const std::vector<int>& count, const std::vector<int>& first, double* all) const {
    MPI_Allgatherv(own, count[rank_], MPI_DOUBLE, all, count.data(), first.data(), MPI_DOUBLE, comm_);
  }

  MPI_Comm comm_;
  int rank_ = 0, total_ = 0;
  bool singular_ = false, analysed_ = false;
  std::vector<int> first_, count_, first4_, count4_;  // cells of each rank, and four values for each
  std::vector<int> neighbour_;                        // cell number beyond each cell's three low faces, or -1
  std::vector<double> mine_, all_;
  std::vector<Eigen::Triplet<double>> entry_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor_;
  Eigen::VectorXd rhs_, solution_;
};

/// The last level of several ranks, whole on every one of them, with a multigrid of its own.
template <class T>
class Multigrid<T>::Gathered {
 public:
  Gathered(MPI_Comm comm, const Level& level, const Lines& lines, const Int3& halo)
      : comm_(comm), boxes_(level.all), whole_(MPI_COMM_SELF, grid(lines, level), layout(lines, level), halo) {
    MPI_Comm_rank(comm, &rank_);
    int cells = 0;
    for (const Box& box : boxes_) {
      first_.push_back(cells);
      count_.push_back(int(box.count()));
      first_faces_.push_back(kFaces * cells);
      count_faces_.push_back(kFaces * count_.back());
      cells += count_.back();
    }
    mine_.resize(std::size_t(kFaces) * count_[rank_]);
    all_.resize(std::size_t(kFaces) * cells);
    for (auto& g : g_) g.reset(Box{{0, 0, 0}, level.n}.grown(1));
  }

  void set_operator(const Level& l, bool singular) {
    double* out = mine_.data();
    for_each(l.own, [&](int i, int j, int k) {
      for (int d = 0; d < 3; ++d) {
        const T* g = &l.g[d].data()[l.g[d].index(i, j, k)];
        *out++ = double(g[0]);
        *out++ = double(g[l.g[d].stride(d)]);
      }
    });
    gather(count_faces_, first_faces_);
    const double* in = all_.data();
    for (const Box& box : boxes_)
      for_each(box, [&](int i, int j, int k) {
        for (int d = 0; d < 3; ++d) {
          double* g = &g_[d](i, j, k);
          g[0] = *in++;
          g[g_[d].stride(d)] = *in++;
        }
      });
    for (int e = 0; e < 3; ++e)
      if (l.periodic[e]) bring_images(e, l.n[e]);
    whole_.set_operator(g_, singular);
  }

  void solve(Level& l) {
    double* out = mine_.data();
    for_each(l.own, [&](int i, int j, int k) { *out++ = double(l.b(i, j, k)); });
    gather(count_, first_);
    const double* in = all_.data();
    for (const Box& box : boxes_) for_each(box, [&](int i, int j, int k) { whole_.b()(i, j, k) = T(*in++); });
    whole_.cycle();
    for_each(l.own, [&](int i, int j, int k) { l.x(i, j, k) = whole_.x()(i, j, k); });
  }

 private:
  static constexpr int kFaces = 6;  // values a cell: conductance of its low and high face in each direction

  /// Faces of the cells beyond the sides of a periodic direction.
  void bring_images(int e, int n) {
    for (auto& g : g_) {
      Box side = g.box();
      side.lo[e] = 0, side.hi[e] = 1;
      for_each(side, [&](int i, int j, int k) {
        double* at = &g(i, j, k);
        at[-g.stride(e)] = at[(n - 1) * g.stride(e)];
        at[n * g.stride(e)] = at[0];
      });
    }
  }
  static Grid grid(const Lines& lines, const Level& level) {
    Grid g;
    for (int d = 0; d < 3; ++d) g.axis[d] = Axis(lines[d].node, level.periodic[d]);
    return g;
  }
  static Layout layout(const Lines& lines, const Level& level) {
    return Layout(grid(lines, level), {std::vector<int>{0, level.n[0]}, {0, level.n[1]}, {0, level.n[2]}});
  }
  void gather(const std::vector<int>& count, const std::vector<int>& first) {
    MPI_Allgatherv(mine_.data(), count[rank_], MPI_DOUBLE, all_.data(), count.data(), first.data(), MPI_DOUBLE, comm_);
  }

  MPI_Comm comm_;
  int rank_ = 0;
  std::vector<Box> boxes_;
  Multigrid<T> whole_;
  std::vector<int> first_, count_, first_faces_, count_faces_;  // by rank: cells, and values of their faces
  std::vector<double> mine_, all_;
  std::array<Array3<double>, 3> g_;
};

template <class T>
Multigrid<T>::Multigrid(MPI_Comm comm, const Grid& grid, const Layout& layout, const Int3& halo) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  Lines lines;
  for (int d = 0; d < 3; ++d) lines[d] = {grid.axis[d].nodes(), layout.cuts()[d]};
  for (;;) {
    std::vector<Box> boxes(layout.ranks());
    for (int r = 0; r < layout.ranks(); ++r)
      for (int d = 0; d < 3; ++d) {
        const int a = layout.brick(r)[d];
        boxes[r].lo[d] = lines[d].cut[a];
        boxes[r].hi[d] = lines[d].cut[a + 1];
      }
    const Int3 n{lines[0].n(), lines[1].n(), lines[2].n()};
    levels_.emplace_back(comm, rank, std::move(boxes), n, grid.periodic(), halo);
    const double cells = double(n[0]) * n[1] * n[2];
    if (cells <= kDirect || (layout.ranks() > 1 && cells <= kGather)) break;
    const Parents parents = choose_pairs(lines, kStretch, kShrink);
    if (parents[0].empty()) break;
    Level& fine = levels_.back();
    for (int d = 0; d < 3; ++d) {
      const std::vector<int>& parent = parents[d];
      auto side = [&](int i) {
        if (i < 0 || i >= n[d]) {
          if (!fine.periodic[d]) return 0;
          i = i < 0 ? i + n[d] : i - n[d];
        }
        return i + 1 < n[d] && parent[i + 1] == parent[i] ? -1 : i > 0 && parent[i - 1] == parent[i] ? 1 : 0;
      };
      for (int i = fine.own.lo[d]; i < fine.own.hi[d]; ++i) {
        fine.parent[d].push_back(parent[i]);
        fine.side[d].push_back(side(i));
      }
      fine.pair_below[d] = side(fine.own.lo[d] - 1) == 1;
      fine.w[d].reset(fine.x.box());
      lines[d] = coarse_line(lines[d], parents[d]);
    }
  }
  const Int3& n = levels_.back().n;
  if (layout.ranks() > 1 && double(n[0]) * n[1] * n[2] > kDirect)
    gathered_ = std::make_unique<Gathered>(comm, levels_.back(), lines, halo);
  else
    coarsest_ = std::make_unique<Coarsest>(comm, levels_.back());
}

template <class T>
Multigrid<T>::~Multigrid() = default;

template <class T>
void Multigrid<T>::set_operator(const std::array<const Array3<double>*, 3>& g, bool singular, double scale) {
  Level& fine = levels_.front();
  for (int d = 0; d < 3; ++d) {
    const Box& b = fine.g[d].box();
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        const double* from = g[d]->data() + g[d]->index(b.lo[0], j, k);
        T* to = fine.g[d].data() + fine.g[d].index(b.lo[0], j, k);
        for (int i = 0; i < b.size(0); ++i) to[i] = T(scale * from[i]);
      }
  }
  fine.finish_operator();
  for (std::size_t l = 0; l + 1 < levels_.size(); ++l) coefficients(levels_[l], levels_[l + 1]);
  if (gathered_)
    gathered_->set_operator(levels_.back(), singular);
  else
    coarsest_->set_operator(levels_.back(), singular);
}

template <class T>
void Multigrid<T>::coefficients(Level& fine, Level& coarse) {
  for (int d = 0; d < 3; ++d) coarse.g[d].fill(0);
  if (!fine.own.empty())
    for (int d = 0; d < 3; ++d) fine.sum_conductances(d, coarse);
  fine.halo.bring({&fine.w[0], &fine.w[1], &fine.w[2]});
  coarse.halo.bring({&coarse.g[0], &coarse.g[1], &coarse.g[2]});
  coarse.finish_operator();
  if (fine.own.empty()) return;
  for (int d = 0; d < 3; ++d) fine.weigh(d);
  fine.limit_weights();
}

template <class T>
void Multigrid<T>::cycle(std::size_t l) {
  using Cells = SevenPointHalo::Cells;
  constexpr int red = 0, black = 1;
  Level& fine = levels_[l];
  if (l + 1 == levels_.size()) {
    if (gathered_)
      gathered_->solve(fine);
    else
      coarsest_->solve(fine);
    return;
  }
  Level& coarse = levels_[l + 1];
  if (fine.odd_seam) fine.x.fill(0);
  fine.start(red);
  fine.halo.bring({&fine.x}, Cells::kRed);
  fine.smooth(black);
  fine.halo.bring({&fine.x}, Cells::kBlack);
  // After the black half sweep black residuals are zero, but for those that meet a black neighbour across an odd seam.
  coarse.b.fill(0);
  fine.restrict_residual(red, coarse);
  if (fine.odd_seam) fine.restrict_residual(black, coarse);
  coarse.halo.add(coarse.b);
  cycle(l + 1);
  coarse.halo.bring({&coarse.x});
  // The black half sweep that follows doesn't read black values, but for those across an odd seam.
  fine.prolong(red, coarse);
  if (fine.odd_seam) fine.prolong(black, coarse);
  fine.halo.bring({&fine.x}, fine.odd_seam ? Cells::kAll : Cells::kRed);
  fine.smooth(black);
  fine.halo.bring({&fine.x}, Cells::kBlack);
  fine.smooth(red);
}

template <class T>
void Multigrid<T>::cycle() {
  cycle(0);
}

template <class T>
Array3<T>& Multigrid<T>::b() {
  return levels_.front().b;
}
template <class T>
Array3<T>& Multigrid<T>::x() {
  return levels_.front().x;
}
template <class T>
int Multigrid<T>::levels() const {
  return int(levels_.size());
}

template class Multigrid<double>;
template class Multigrid<float>;

}  // namespace twogrid
