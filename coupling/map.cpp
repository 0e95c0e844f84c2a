#include "map.h"

#include <algorithm>
#include <cmath>

#include "../cfd/vectorised.h"

namespace twogrid {

namespace {

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

std::vector<Box> grown(std::vector<Box> boxes, const Int3& lo, const Int3& hi) {
  for (Box& b : boxes)
    if (!b.empty())
      for (int d = 0; d < 3; ++d) b.lo[d] -= lo[d], b.hi[d] += hi[d];
  return boxes;
}

}  // namespace

Map::Map(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid)
    : fluid_(&fluid), grid_(grid), layout_(node_layout(fluid.layout(), grid)), fine_(fluid.grid()) {
  const int rank = rank_of(comm);
  own_ = layout_.cells(rank);
  const std::vector<Box> below = grown(layout_.all_cells(), {1, 1, 1}, {0, 0, 0});
  below_ = BlockExchange(comm, layout_.all_cells(), below, grid_.n(), grid_.periodic());
  for (int d = 0; d < 3; ++d) {
    const Axis& a = fine_.axis[d];
    const int n = a.n(), r = grid_.ratio[d];
    for (int i = 0; i < n; ++i) width_[d].push_back(a.width(i));
    for (int i = 0; i <= n; ++i) {
      const bool inside_below = a.periodic() || i > 0, inside_above = a.periodic() || i < n;
      const double below = inside_below ? 0.5 * a.width(i - 1) : 0.0, above = inside_above ? 0.5 * a.width(i) : 0.0;
      face_width_[d].push_back(below + above);
      above_[d].push_back(i % r != 0 ? 1.0 : above / (below + above));
      block_[d].push_back(i / r);
    }
  }
  for (int d = 0; d < 3; ++d) {
    faces_[d] = fluid.layout().faces(d, rank);
    const Axis& a = fine_.axis[d];
    const int r = grid_.ratio[d];
    half_[d].resize(std::size_t(grid_.n()[d]) * (r + 1));
    for (int n = 0; n < grid_.n()[d]; ++n)
      for (int m = 0; m <= r; ++m)
        half_[d][n * (r + 1) + m] = 0.5 * ((m > 0 ? a.width(n * r + m - 1) : 0) + (m < r ? a.width(n * r + m) : 0));
    inverse_[d].reset(own_);
    const Array3<FaceState>& state = fluid.face_state(d);
    for_each(own_, [&](int I, int J, int K) {
      Box b = grid_.block(I, J, K);
      const Int3 first = b.lo, node{I, J, K};
      ++b.hi[d];
      double sum = 0;
      for_each(b, [&](int i, int j, int k) {
        if (state(i, j, k) == FaceState::kFixed) return;
        const Int3 c{i, j, k};
        sum += fine_.area(d, i, j, k) * half_[d][node[d] * (r + 1) + c[d] - first[d]];
      });
      inverse_[d](I, J, K) = sum > 0 ? 1 / sum : 0.0;
    });
    const auto look = [&](const Box& b, std::vector<unsigned char>& any_fixed) {
      for (int k = b.lo[2]; k < b.hi[2]; ++k)
        for (int j = b.lo[1]; j < b.hi[1]; ++j) {
          const FaceState* s = &state.data()[state.index(b.lo[0], j, k)];
          any_fixed.push_back(std::find(s, s + b.size(0), FaceState::kFixed) != s + b.size(0));
        }
    };
    look(faces_[d], may_be_fixed_[d]);
    if (own_.empty()) continue;
    for (int e = 0; e < 3; ++e) {
      rows_[d].lo[e] = own_.lo[e] * grid_.ratio[e];
      rows_[d].hi[e] = own_.hi[e] * grid_.ratio[e] + (e == d);
    }
    look(rows_[d], checked_[d]);
  }
  with_below_ = below[rank];
}

namespace {

/// node[I] += sum over its cells i of weight w_i u_i, or with kNormal over its r + 1 faces; fixed faces left out.
/// Widths start with the first node's first cell (kNormal: face). state: null if no face of the row is fixed.
template <bool kNormal, bool kFixed>
inline void add_row(int nodes, int r, double weight, const double* width, const double* u, const FaceState* state,
                    double* __restrict node) {
  const int faces = kNormal ? r + 1 : r;
  const auto open = [&](int i) { return !kFixed || state[i] == FaceState::kSolved; };
  if (r == 1) {
    for (int I = 0; I < nodes; ++I)
      for (int i = 0; i < (kNormal ? 2 : 1); ++i)
        node[I] += open(I + i) ? weight * width[I * (kNormal ? 2 : 1) + i] * u[I + i] : 0.0;
    return;
  }
  for (int I = 0, first = 0; I < nodes; ++I, width += faces, first += r) {
    double sum = node[I];
    for (int i = 0; i < faces; ++i) sum += open(first + i) ? weight * width[i] * u[first + i] : 0.0;
    node[I] = sum;
  }
}

template <bool kNormal>
inline void add_row(int nodes, int r, double weight, const double* width, const double* u, const FaceState* state,
                    double* node) {
  if (state)
    add_row<kNormal, true>(nodes, r, weight, width, u, state, node);
  else
    add_row<kNormal, false>(nodes, r, weight, width, u, state, node);
}

TWOGRID_VECTORISED void add_row(bool normal, int nodes, int r, double weight, const double* width, const double* u,
                                const FaceState* state, double* node) {
  if (normal)
    add_row<true>(nodes, r, weight, width, u, state, node);
  else
    add_row<false>(nodes, r, weight, width, u, state, node);
}

}  // namespace

void Map::mean(const FaceField<FineGrid>& face, NodeVector<CellField<ParticleGrid>>& node) const {
  if (own_.empty()) return;
  const int nodes = own_.size(0), r = grid_.ratio[0], first = own_.lo[0] * r;
  for (int d = 0; d < 3; ++d) {
    const Array3<FaceState>& state = fluid_->face_state(d);
    const FaceComponent<FineGrid>& u = face[d];
    const int faces_x = d == 0 ? r + 1 : r;
    const double* width_x = d == 0 ? &half_[0][std::size_t(own_.lo[0]) * faces_x] : &width_[0][first];
    for (int K = own_.lo[2]; K < own_.hi[2]; ++K)
      for (int J = own_.lo[1]; J < own_.hi[1]; ++J) {
        const Box b = grid_.block(own_.lo[0], J, K);
        double* const out = &node[d](own_.lo[0], J, K);
        const double* const inverse = &inverse_[d].data()[inverse_[d].index(own_.lo[0], J, K)];
        std::fill(out, out + nodes, 0.0);
        for (int k = b.lo[2]; k < b.hi[2] + (d == 2); ++k) {
          const double wk = d == 2 ? half_[2][std::size_t(K) * (grid_.ratio[2] + 1) + (k - b.lo[2])] : width_[2][k];
          for (int j = b.lo[1]; j < b.hi[1] + (d == 1); ++j) {
            const double wjk =
                wk * (d == 1 ? half_[1][std::size_t(J) * (grid_.ratio[1] + 1) + (j - b.lo[1])] : width_[1][j]);
            const double* row = &u.data()[u.index(first, j, k)];
            const bool checked =
                checked_[d][(j - rows_[d].lo[1]) + std::size_t(rows_[d].size(1)) * (k - rows_[d].lo[2])];
            add_row(d == 0, nodes, r, wjk, width_x, row, checked ? &state.data()[state.index(first, j, k)] : nullptr,
                    out);
          }
        }
        for (int I = 0; I < nodes; ++I) out[I] *= inverse[I];
      }
  }
}

Vec3 Map::spread(const std::array<const CellField<ParticleGrid>*, 3>& node, NodeSpread& density) const {
  Vec3 held_back{0, 0, 0};
  density.map_ = this;
  auto& share = density.share_;
  for (int d = 0; d < 3; ++d) {
    if (!(share[d].box() == with_below_)) share[d].reset(with_below_);
    double sum = 0;
    for_each(own_, [&](int I, int J, int K) {
      const double q = (*node[d])(I, J, K), inverse = inverse_[d](I, J, K);
      share[d](I, J, K) = q * inverse;
      if (inverse == 0) sum += q;
    });
    held_back[d] = sum;
  }
  below_.bring<double>({&share[0], &share[1], &share[2]});
  return held_back;
}

template <int d>
inline void NodeSpread::fill_row(int i, int j, int k, int n, double* out) const {
  const Map& map = *map_;
  const std::array<const int*, 3> block{map.block_[0].data(), map.block_[1].data(), map.block_[2].data()};
  const CellField<ParticleGrid>& share = share_[d];
  const std::ptrdiff_t down = d == 0 ? 1 : share.stride(d);
  const double* row = share.data() + share.index(0, block[1][j], block[2][k]);
  // A value of the block, and those of its faces: all the same but, along d, for the first.
  auto value = [&](const double* s, double above) {
    if (above >= 1) return *s;
    return above > 0 ? above * *s + (1 - above) * s[-down] : s[-down];
  };
  const int r = map.grid_.ratio[0], end = i + n;
  if (r == 1) {
    const double *const s = row + i, *const below = s - down;
    if (d != 0) {
      const double above = map.above_[d][d == 1 ? j : k], rest = 1 - above;
      if (above == 0 || above == 1)
        std::copy_n(above == 1 ? s : below, n, out);
      else
        for (int q = 0; q < n; ++q) out[q] = above * s[q] + rest * below[q];
      return;
    }
    const double* const above = &map.above_[0][i];
    const int nodes = std::min(n, map.grid_.n()[0] - i);  // there is none above the last face
    for (int q = 0; q < nodes; ++q) out[q] = above[q] * s[q] + (1 - above[q]) * below[q];
    for (int q = nodes; q < n; ++q) out[q] = value(s + q, above[q]);
    return;
  }
  while (i < end) {
    const double* s = row + block[0][i];
    const int next = std::min(end, i - i % r + r);
    if (d == 0) {
      *out++ = value(s, map.above_[0][i]), ++i;
      if (i < next) out = std::fill_n(out, next - i, *s);
    } else {
      out = std::fill_n(out, next - i, value(s, map.above_[d][d == 1 ? j : k]));
    }
    i = next;
  }
}

void NodeSpread::row(int d, int i, int j, int k, int n, double* out) const {
  if (n == 0) return;  // a rank without cells
  d == 0 ? fill_row<0>(i, j, k, n, out) : d == 1 ? fill_row<1>(i, j, k, n, out) : fill_row<2>(i, j, k, n, out);
  const Box& b = map_->faces_[d];
  if (!map_->may_be_fixed_[d][(j - b.lo[1]) + std::size_t(b.size(1)) * (k - b.lo[2])]) return;
  const Array3<FaceState>& state = map_->fluid_->face_state(d);
  const FaceState* fixed = &state.data()[state.index(i, j, k)];
  for (int q = 0; q < n; ++q)
    if (fixed[q] == FaceState::kFixed) out[q] = 0;
}

void NodeSpread::field(int d, Array3<double>& out) const {
  const Box& b = map_->faces_[d];
  out.reset(b);
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) row(d, b.lo[0], j, k, b.size(0), &out.data()[out.index(b.lo[0], j, k)]);
}

Inject::Inject(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& grid, Prolong kind,
               double eps_min)
    : fine_(fine), grid_(grid), kind_(kind), eps_min_(eps_min) {
  const int rank = rank_of(comm);
  const Layout nodes = node_layout(layout, grid);
  own_nodes_ = nodes.cells(rank);
  own_cells_ = layout.cells(rank);
  node_halo_ =
      BlockExchange(comm, nodes.all_cells(), grown(nodes.all_cells(), {1, 1, 1}, {1, 1, 1}), grid.n(), grid.periodic());
  fine_halo_ = BlockExchange(comm, layout.all_cells(), grown(layout.all_cells(), {2, 2, 2}, {2, 2, 2}), fine.n(),
                             fine.periodic());
}

void Inject::constant(const CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const {
  const Int3 r = grid_.ratio;
  for_each(own_cells_, [&](int i, int j, int k) { fine(i, j, k) = node(i / r[0], j / r[1], k / r[2]); });
  fill_halo(fine);
}

void Inject::operator()(CellField<ParticleGrid>& node, CellField<FineGrid>& fine) const {
  if (kind_ == Prolong::kConstant || grid_.ratio == Int3{1, 1, 1}) {
    constant(node, fine);
    return;
  }
  node_halo_.bring<double>(node);
  const Int3 n = grid_.n();
  for_each(own_nodes_, [&](int I, int J, int K) {
    const Int3 c{I, J, K};
    const double e = node(I, J, K);
    const Box block = grid_.block(I, J, K);
    Vec3 slope{0, 0, 0};
    double deviation = 0;  // largest of the profile
    for (int d = 0; d < 3; ++d) {
      const Axis& a = grid_.axis[d];
      if (grid_.ratio[d] == 1 || (!a.periodic() && (c[d] == 0 || c[d] == n[d] - 1))) continue;
      Int3 lo = c, hi = c;
      --lo[d], ++hi[d];
      const double below = (e - node(lo[0], lo[1], lo[2])) / (a.centre(c[d]) - a.centre(c[d] - 1));
      const double above = (node(hi[0], hi[1], hi[2]) - e) / (a.centre(c[d] + 1) - a.centre(c[d]));
      if (below * above > 0) slope[d] = std::abs(below) < std::abs(above) ? below : above;
      const Axis& f = fine_.axis[d];
      deviation += std::abs(slope[d]) *
                   std::max(a.centre(c[d]) - f.centre(block.lo[d]), f.centre(block.hi[d] - 1) - a.centre(c[d]));
    }
    if (deviation > 0) {
      const double room = std::max(0.0, std::min(1 - e, e - eps_min_));
      if (deviation > room)
        for (double& s : slope) s *= room / deviation;
    }
    for_each(block, [&](int i, int j, int k) {
      const Axis* f = fine_.axis.data();
      fine(i, j, k) = e + slope[0] * (f[0].centre(i) - grid_.axis[0].centre(I)) +
                      slope[1] * (f[1].centre(j) - grid_.axis[1].centre(J)) +
                      slope[2] * (f[2].centre(k) - grid_.axis[2].centre(K));
    });
  });
  fill_halo(fine);
}

void Inject::fill_halo(CellField<FineGrid>& fine) const {
  fine_halo_.bring<double>(fine);
  if (own_cells_.empty()) return;
  // Copies beyond the sides, one direction after the other, so that edges and corners are filled too.
  Box done = fine.box();
  for (int d = 0; d < 3; ++d)
    if (!fine_.axis[d].periodic()) {
      done.lo[d] = std::max(done.lo[d], 0);
      done.hi[d] = std::min(done.hi[d], fine_.axis[d].n());
    }
  for (int d = 0; d < 3; ++d) {
    if (fine_.axis[d].periodic()) continue;
    const int n = fine_.axis[d].n();
    Box beyond = done;
    beyond.lo[d] = fine.box().lo[d], beyond.hi[d] = 0;
    for_each(beyond, [&](int i, int j, int k) {
      Int3 c{i, j, k};
      c[d] = 0;
      fine(i, j, k) = fine(c[0], c[1], c[2]);
    });
    beyond.lo[d] = n, beyond.hi[d] = fine.box().hi[d];
    for_each(beyond, [&](int i, int j, int k) {
      Int3 c{i, j, k};
      c[d] = n - 1;
      fine(i, j, k) = fine(c[0], c[1], c[2]);
    });
    done.lo[d] = fine.box().lo[d], done.hi[d] = fine.box().hi[d];
  }
}

}  // namespace twogrid
