#include "cfd/pressure/multigrid.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>

#include "cfd/parallel/ranks.h"
#include "cfd/pressure/multigrid_level.h"
#include "cfd/pressure/pairs.h"

namespace twogrid {

/// The smallest level, gathered on every rank and solved by a sparse LDL^T there. A diagonal raised by 1e-10 keeps it
/// definite where cells are cut off from all boundaries; where the whole grid is (singular), means are taken out.
template <class T>
class Multigrid<T>::Coarsest {
 public:
  Coarsest(MPI_Comm comm, const Level& level) : comm_(comm) {
    const int ranks = ranks_of(comm);
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
    rank_ = rank_of(comm);
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
    closed_.clear();
    for (int c = 0; c < total_; ++c)
      if (!(all_[4 * c + 3] > 0)) closed_.push_back(c);
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
    if (singular_) take_mean_out(rhs_);
    solution_ = factor_.solve(rhs_);
    if (singular_) take_mean_out(solution_);
    int m = first_[rank_];
    for_each(l.own, [&](int i, int j, int k) { l.x(i, j, k) = T(solution_[m++]); });
  }

 private:
  /// Of the cells that have a neighbour; the others get zero.
  void take_mean_out(Eigen::VectorXd& v) const {
    if (closed_.empty()) {
      v.array() -= v.mean();
      return;
    }
    for (int c : closed_) v[c] = 0;
    v.array() -= v.sum() / std::max(1, total_ - int(closed_.size()));
    for (int c : closed_) v[c] = 0;
  }
  void gather(const double* own, const std::vector<int>& count, const std::vector<int>& first, double* all) const {
    MPI_Allgatherv(own, count[rank_], MPI_DOUBLE, all, count.data(), first.data(), MPI_DOUBLE, comm_);
  }

  MPI_Comm comm_;
  int rank_ = 0, total_ = 0;
  bool singular_ = false, analysed_ = false;
  std::vector<int> first_, count_, first4_, count4_;  // cells of each rank, and four values for each
  std::vector<int> closed_;                           // cells without any conductance: bodies
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
    rank_ = rank_of(comm);
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

namespace {

/// The given rows of the first level; of a coarser one all parents of the finer one's.
template <class T>
std::unique_ptr<const OpenRows> open_rows(const std::vector<MultigridLevel<T>>& levels, const OpenRows& of_first) {
  if (levels.size() == 1) return std::make_unique<const OpenRows>(of_first);
  const MultigridLevel<T>&level = levels.back(), &fine = levels[levels.size() - 2];
  Array3<char> open(level.own, 0);
  for (int k = fine.own.lo[2]; k < fine.own.hi[2]; ++k)
    for (int j = fine.own.lo[1]; j < fine.own.hi[1]; ++j) {
      const OpenRows::Part p = fine.open->bare(j, k);
      for (int i = p.begin; i < p.end; ++i)
        open(fine.parent[0][i - fine.own.lo[0]], fine.parent[1][j - fine.own.lo[1]],
             fine.parent[2][k - fine.own.lo[2]]) = 1;
    }
  return std::make_unique<const OpenRows>(level.own, OpenRows::kFloats,
                                          [&](int i, int j, int k) { return open(i, j, k) != 0; });
}

}  // namespace

template <class T>
Multigrid<T>::Multigrid(MPI_Comm comm, const Grid& grid, const Layout& layout, const Int3& halo, const OpenRows* open) {
  const int rank = rank_of(comm);
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
    if (open) levels_.back().open = open_rows(levels_, *open);
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
  for (std::size_t l = 0; l < levels_.size(); ++l)
    levels_[l].list_rows(l + 1 < levels_.size() ? &levels_[l + 1] : nullptr);
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
