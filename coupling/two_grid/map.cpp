#include "coupling/two_grid/map.h"

#include <algorithm>
#include <cmath>

#include "cfd/parallel/ranks.h"
#include "cfd/parallel/vectorised.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

Map::Map(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid)
    : grid_(grid), layout_(node_layout(fluid.layout(), grid)), shares_(fluid.open_shares()), fine_(fluid.grid()) {
  const int rank = rank_of(comm);
  own_ = layout_.cells(rank);
  const std::vector<Box> below = with_halo(layout_.all_cells(), {1, 1, 1}, {0, 0, 0});
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
      const double width_below = inside_below ? a.width(i - 1) : a.width(i),
                   width_above = inside_above ? a.width(i) : a.width(i - 1);
      above_share_[d].push_back(width_above / (width_below + width_above));
      block_[d].push_back(i / r);
    }
  }
  for (int d = 0; d < 3; ++d) {
    faces_[d] = fluid.layout().faces(d, rank);
    const Axis& a = fine_.axis[d];
    const int r = grid_.ratio[d];
    const int nodes = grid_.n()[d];
    half_[d].resize(std::size_t(nodes) * (r + 1));
    for (int m = 0; m <= r; ++m)
      for (int n = 0; n < nodes; ++n)
        half_[d][m * nodes + n] = 0.5 * ((m > 0 ? a.width(n * r + m - 1) : 0) + (m < r ? a.width(n * r + m) : 0));
    inverse_[d].reset(own_);
    holds_back_[d] = false;
    const Array3<FaceState>& state = fluid.face_state(d);
    for_each(own_, [&](int I, int J, int K) {
      Box b = grid_.block(I, J, K);
      const Int3 first = b.lo, node{I, J, K};
      ++b.hi[d];
      double sum = 0;
      for_each(b, [&](int i, int j, int k) {
        if (state(i, j, k) == FaceState::kFixed) return;
        const Int3 c{i, j, k};
        sum += fine_.area(d, i, j, k) * half_[d][(c[d] - first[d]) * nodes + node[d]];
      });
      inverse_[d](I, J, K) = sum > 0 ? 1 / sum : 0.0;
      if (!(sum > 0)) holds_back_[d] = true;
    });
    if (own_.empty()) continue;
    Box of_own_nodes;
    for (int e = 0; e < 3; ++e) {
      of_own_nodes.lo[e] = own_.lo[e] * grid_.ratio[e];
      of_own_nodes.hi[e] = own_.hi[e] * grid_.ratio[e] + (e == d);
    }
    open_[d] = OpenFaces(state, of_own_nodes);
  }
  for (int d = 0; shares_ && d < 3; ++d) {
    const Axis& a = fine_.axis[d];
    for (int i = 0; i <= a.n(); ++i) upper_half_[d].push_back(i < a.n() ? 0.5 * width_[d][i] / face_width_[d][i] : 0.0);
    holds_back_[d] = false;
    CellField<ParticleGrid>& sum = inverse_[d];
    for_each(own_,
             [&](int I, int J, int K) { sum(I, J, K) = open_sum(d, I, J, K, [](int, int, int) { return 1.0; }); });
    if (const OpenNodes* families = grid_.open_nodes()) families->total(slot_of<double>(sum));
    for_each(own_, [&](int I, int J, int K) {
      if (!(sum(I, J, K) > 0)) holds_back_[d] = true;
      sum(I, J, K) = sum(I, J, K) > 0 ? 1 / sum(I, J, K) : 0.0;
    });
  }
  with_below_ = below[rank];
  row_.resize(std::size_t(own_.size(0)) * grid_.ratio[0] + 1);
  flux_.resize(row_.size());
}

/// Sum over the node's faces of W_nf times the value: each open cell of it gives half of its open volume to either face
/// that is solved for.
template <class Value>
double Map::open_sum(int d, int I, int J, int K, Value value) const {
  const int first = own_.lo[0] * grid_.ratio[0];
  const CellField<FineGrid>& theta = shares_->theta();
  double sum = 0;
  for_each(grid_.block(I, J, K), [&](int i, int j, int k) {
    const double half = 0.5 * theta(i, j, k) * width_[0][i] * width_[1][j] * width_[2][k];
    if (half == 0) return;
    for (int side : {0, 1}) {
      Int3 f{i, j, k};
      f[d] += side;
      const double* const open = open_[d].row(f[1], f[2]);
      if (!open || open[f[0] - first] > 0) sum += half * value(f[0], f[1], f[2]);
    }
  });
  return sum;
}

void Map::mean_of_open(const FaceField<FineGrid>& face, const Slot<FourNumbers>& node,
                       const CellField<FineGrid>* eps) const {
  const CellField<FineGrid>& theta = shares_->theta();
  sums_.assign(own_.count(), FourNumbers{});
  const Slot<FourNumbers> sums{own_, sums_.data(), 1};
  for (int d = 0; d < 3; ++d)
    for_each(own_, [&](int I, int J, int K) {
      sums_[sums.index(I, J, K)].at[d] = open_sum(d, I, J, K, [&](int i, int j, int k) {
        if (!eps) return face[d](i, j, k);
        // eps_f of the open space: theta eps over theta_f.
        Int3 below{i, j, k};
        const double share = above_share_[d][below[d]];
        --below[d];
        const double high = share * theta(i, j, k), low = (1 - share) * theta(below[0], below[1], below[2]);
        return face[d](i, j, k) * (high * (*eps)(i, j, k) + low * (*eps)(below[0], below[1], below[2])) / (high + low);
      });
    });
  if (const OpenNodes* families = grid_.open_nodes()) families->total(sums);
  for_each(own_, [&](int I, int J, int K) {
    for (int d = 0; d < 3; ++d)
      node.data[node.stride * node.index(I, J, K)].at[d] = sums_[sums.index(I, J, K)].at[d] * inverse_[d](I, J, K);
  });
}

double Map::integral(int d, int j, int k, const double* density) const {
  const Box& b = faces_[d];
  const Int3 c{0, j, k};
  double across = 1;
  for (int e = 1; e < 3; ++e) across *= (e == d ? face_width_[e] : width_[e])[c[e]];
  const double* const width = (d == 0 ? face_width_[0] : width_[0]).data() + b.lo[0];
  const int n = b.size(0);
  Four sums{0, 0, 0, 0};
  int i = 0;
  for (; i + 4 <= n; i += 4) sums += four_at(density + i).row * four_at(width + i).row;
  double sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  for (; i < n; ++i) sum += density[i] * width[i];
  return sum * across;
}

namespace {

/// sum = or += weight u over the faces that are open (null: all).
template <bool kFirst>
inline void add_row(int n, double weight, const double* u, const double* open, double* __restrict sum) {
  if (open)
    for (int i = 0; i < n; ++i) sum[i] = (kFirst ? 0.0 : sum[i]) + weight * open[i] * u[i];
  else
    for (int i = 0; i < n; ++i) sum[i] = (kFirst ? 0.0 : sum[i]) + weight * u[i];
}

/// flux = eps_f u of a row of n faces. down: from a cell of eps to the one below the face.
template <bool kNormal>
inline void flux_row(int n, const double* u, const double* eps, std::ptrdiff_t down, const double* above_share,
                     double* __restrict flux) {
  for (int i = 0; i < n; ++i) {
    const double below = eps[i - down], share = kNormal ? above_share[i] : *above_share;
    flux[i] = u[i] * (below + share * (eps[i] - below));
  }
}

/// A row of nodes from the sums over y and z of its faces: node[stride I] = inverse[I] times the sum over the block's
/// faces m of width sum. kNormal: the row runs along d, and face m of node I has the width width[m all_nodes + I].
template <bool kNormal>
inline void sum_blocks(int nodes, int r, std::ptrdiff_t all_nodes, const double* width, const double* sum,
                       const double* inverse, std::ptrdiff_t stride, double* __restrict node) {
  if (r == 1) {
    for (int I = 0; I < nodes; ++I) {
      const double all = kNormal ? width[I] * sum[I] + width[all_nodes + I] * sum[I + 1] : width[I] * sum[I];
      node[stride * I] = inverse[I] * all;
    }
    return;
  }
  for (int I = 0; I < nodes; ++I, sum += r) {
    double all = 0;
    for (int m = 0; m < r + kNormal; ++m) all += (kNormal ? width[all_nodes * m + I] : width[r * I + m]) * sum[m];
    node[stride * I] = inverse[I] * all;
  }
}

}  // namespace

TWOGRID_VECTORISED void Map::mean(const FaceField<FineGrid>& face, const Slot<FourNumbers>& node,
                                  const CellField<FineGrid>* eps) const {
  if (shares_) {
    mean_of_open(face, node, eps);
    return;
  }
  if (own_.empty()) return;
  const int nodes = own_.size(0), r = grid_.ratio[0], first = own_.lo[0] * r;
  const std::ptrdiff_t stride = 4 * node.stride;
  double* const sum = row_.data();
  for (int d = 0; d < 3; ++d) {
    const FaceComponent<FineGrid>& u = face[d];
    const int faces = nodes * r + (d == 0);
    const double* const width = d == 0 ? &half_[0][own_.lo[0]] : &width_[0][first];
    for (int K = own_.lo[2]; K < own_.hi[2]; ++K)
      for (int J = own_.lo[1]; J < own_.hi[1]; ++J) {
        const Box b = grid_.block(own_.lo[0], J, K);
        bool fresh = true;
        for (int k = b.lo[2]; k < b.hi[2] + (d == 2); ++k) {
          const double wk = d == 2 ? half_[2][(k - b.lo[2]) * grid_.n()[2] + K] : width_[2][k];
          for (int j = b.lo[1]; j < b.hi[1] + (d == 1); ++j) {
            const double weight = wk * (d == 1 ? half_[1][(j - b.lo[1]) * grid_.n()[1] + J] : width_[1][j]);
            const double* row = &u.data()[u.index(first, j, k)];
            if (eps) {
              const double* const e = &eps->data()[eps->index(first, j, k)];
              const double* const share = d == 0 ? &above_share_[0][first] : &above_share_[d][d == 1 ? j : k];
              if (d == 0)
                flux_row<true>(faces, row, e, 1, share, flux_.data());
              else
                flux_row<false>(faces, row, e, eps->stride(d), share, flux_.data());
              row = flux_.data();
            }
            if (fresh)
              add_row<true>(faces, weight, row, open_[d].row(j, k), sum);
            else
              add_row<false>(faces, weight, row, open_[d].row(j, k), sum);
            fresh = false;
          }
        }
        const double* const inverse = &inverse_[d].data()[inverse_[d].index(own_.lo[0], J, K)];
        double* const out = node.data[node.stride * node.index(own_.lo[0], J, K)].at + d;
        if (d == 0)
          sum_blocks<true>(nodes, r, grid_.n()[0], width, sum, inverse, stride, out);
        else
          sum_blocks<false>(nodes, r, grid_.n()[0], width, sum, inverse, stride, out);
      }
  }
}

namespace {

/// q_n / W_n of a row of nodes: of components 0-2 to source, of component 3 to beta.
TWOGRID_VECTORISED void share_out(int nodes, const FourWholeNumbers* node, int stride, const Four& unit,
                                  const std::array<const double*, 3>& inverse, const std::array<double*, 3>& source,
                                  const std::array<double*, 3>& beta) {
  for (int I = 0; I < nodes; ++I, node += stride) {
    const FourIntegers whole = four_at(node->at).row;
    Four q;
    to_doubles(whole, q);
    q *= unit;
    for (int d = 0; d < 3; ++d) {
      source[d][I] = q[d] * inverse[d][I];
      beta[d][I] = q[3] * inverse[d][I];
    }
  }
}

}  // namespace

Vec3 Map::spread(const Slot<FourWholeNumbers>& node, const std::array<FixedPoint, 2>& scale, NodeSpread& source,
                 NodeSpread& beta) const {
  Vec3 held_back{0, 0, 0};
  for (NodeSpread* to : {&source, &beta}) {
    to->map_ = this;
    for (auto& share : to->share_)
      if (!(share.box() == with_below_)) share.reset(with_below_);
  }
  const double f = scale[0].unit(), g = scale[1].unit();
  const Four unit{f, f, f, g};
  std::vector<FourWholeNumbers> totals;
  Slot<FourWholeNumbers> total = node;
  if (const OpenNodes* families = grid_.open_nodes()) {
    totals.resize(own_.count());
    total = {own_, totals.data(), 1};
    for_each(own_,
             [&](int i, int j, int k) { totals[total.index(i, j, k)] = node.data[node.stride * node.index(i, j, k)]; });
    families->total(total);
  }
  const int slabs = own_.empty() ? 0 : own_.size(2);
  for (int K = own_.lo[2]; K < own_.lo[2] + slabs; ++K)
    for (int J = own_.lo[1]; J < own_.hi[1]; ++J) {
      const FourWholeNumbers* const row = node.data + node.stride * node.index(own_.lo[0], J, K);
      std::array<const double*, 3> inverse;
      std::array<double*, 3> to[2];
      for (int d = 0; d < 3; ++d) {
        inverse[d] = &inverse_[d].data()[inverse_[d].index(own_.lo[0], J, K)];
        to[0][d] = &source.share_[d](own_.lo[0], J, K);
        to[1][d] = &beta.share_[d](own_.lo[0], J, K);
      }
      const FourWholeNumbers* const shared = total.data + total.stride * total.index(own_.lo[0], J, K);
      share_out(own_.size(0), shared, total.stride, unit, inverse, to[0], to[1]);
      for (int d = 0; d < 3; ++d)
        if (holds_back_[d])
          for (int I = 0; I < own_.size(0); ++I)
            if (inverse[d][I] == 0) held_back[d] += scale[0].value(row[node.stride * I].at[d]);
    }
  below_.bring<double>(
      {&source.share_[0], &source.share_[1], &source.share_[2], &beta.share_[0], &beta.share_[1], &beta.share_[2]});
  return held_back;
}

namespace {

/// A row of faces whose blocks are single cells: mean of the values of the nodes at either side, as `above` weighs
/// them.
template <bool kNormal>
inline void between_nodes(int n, const double* node, std::ptrdiff_t down, const double* above, double* __restrict out) {
  for (int q = 0; q < n; ++q) {
    const double w = kNormal ? above[q] : *above;
    out[q] = w * node[q] + (1 - w) * node[q - down];
  }
}

/// The same where blocks are r cells wide, from cell i on. Faces inside a block have its value.
template <bool kNormal>
inline void between_blocks(int i, int n, int r, const double* node, std::ptrdiff_t down, const double* above,
                           double* __restrict out) {
  const int end = i + n;
  for (node += i / r; i < end; ++node) {
    const int next = std::min(end, i - i % r + r);
    // Above the last face there is no node.
    const double first = kNormal ? above[i] : *above;
    const double value = first >= 1 ? *node : first > 0 ? first * *node + (1 - first) * node[-down] : node[-down];
    if (!kNormal) {
      for (; i < next; ++i) *out++ = value;
      continue;
    }
    *out++ = value, ++i;
    for (; i < next; ++i) *out++ = *node;
  }
}

}  // namespace

TWOGRID_VECTORISED void NodeSpread::fill_row(int d, int i, int j, int k, int n, double* out) const {
  const Map& map = *map_;
  const CellField<ParticleGrid>& share = share_[d];
  const int r = map.grid_.ratio[0];
  const std::ptrdiff_t down = d == 0 ? 1 : share.stride(d);
  const double* const node = share.data() + share.index(0, map.block_[1][j], map.block_[2][k]);
  const double* const above = d == 0 ? map.above_[0].data() : &map.above_[d][d == 1 ? j : k];
  if (d == 0 && r == 1) {
    const int nodes = std::min(n, map.grid_.n()[0] - i);  // there is none above the last face
    between_nodes<true>(nodes, node + i, 1, above + i, out);
    if (nodes < n) out[nodes] = node[i + nodes - 1];
  } else if (d == 0) {
    between_blocks<true>(i, n, r, node, 1, above, out);
  } else if (r > 1) {
    between_blocks<false>(i, n, r, node, down, above, out);
  } else if (*above == 0 || *above == 1) {
    std::copy_n(node + i - (*above == 0 ? down : 0), n, out);
  } else {
    between_nodes<false>(n, node + i, down, above, out);
  }
  const double* const open = map.open_[d].row(j, k);
  if (!open) return;
  const double* const factor = open + (i - map.faces_[d].lo[0]);
  for (int q = 0; q < n; ++q) out[q] *= factor[q];
}

/// The same with open shares: either half of the face's volume has the value of the node it lies in, times theta.
TWOGRID_VECTORISED void NodeSpread::fill_open_row(int d, int i, int j, int k, int n, double* __restrict out) const {
  const Map& map = *map_;
  const CellField<ParticleGrid>& share = share_[d];
  const CellField<FineGrid>& theta = map.shares_->theta();
  const std::ptrdiff_t down = share.stride(d), lower = theta.stride(d);
  const double* const node = share.data() + share.index(0, map.block_[1][j], map.block_[2][k]);
  const double* const cell = theta.data() + theta.index(i, j, k);
  const int* const block = map.block_[0].data() + i;
  const double* const half = d == 0 ? map.upper_half_[0].data() + i : &map.upper_half_[d][d == 1 ? j : k];
  if (d == 0) {
    const int end = std::min(n, map.grid_.n()[0] * map.grid_.ratio[0] - i);
    const auto between = [&](int q, int under) {
      return half[q] * cell[q] * node[block[q]] + (1 - half[q]) * cell[q - 1] * node[under];
    };
    // Below the first face and above the last there may be no cell.
    if (i == 0) out[0] = half[0] < 1 ? between(0, block[0] - 1) : cell[0] * node[block[0]];
    for (int q = i == 0 ? 1 : 0; q < end; ++q) out[q] = between(q, block[q - 1]);
    if (end < n) out[end] = cell[end - 1] * node[block[end - 1]];
  } else {
    const int at = d == 1 ? j : k, under = at > 0 ? map.block_[d][at - 1] : -1;
    const double* const low = node - (map.block_[d][at] - under) * down;
    const double upper = *half;
    if (upper == 0)
      for (int q = 0; q < n; ++q) out[q] = cell[q - lower] * low[block[q]];
    else if (upper == 1)
      for (int q = 0; q < n; ++q) out[q] = cell[q] * node[block[q]];
    else
      for (int q = 0; q < n; ++q)
        out[q] = upper * cell[q] * node[block[q]] + (1 - upper) * cell[q - lower] * low[block[q]];
  }
  const double* const open = map.open_[d].row(j, k);
  if (!open) return;
  const double* const factor = open + (i - map.faces_[d].lo[0]);
  for (int q = 0; q < n; ++q) out[q] *= factor[q];
}

void NodeSpread::row(int d, int i, int j, int k, int n, double* out) const {
  if (n <= 0) return;  // a rank without cells
  if (map_->shares_)
    fill_open_row(d, i, j, k, n, out);
  else
    fill_row(d, i, j, k, n, out);
}

void NodeSpread::field(int d, Array3<double>& out) const {
  const Box& b = map_->faces_[d];
  out.reset(b);
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) row(d, b.lo[0], j, k, b.size(0), &out.data()[out.index(b.lo[0], j, k)]);
}

}  // namespace twogrid
