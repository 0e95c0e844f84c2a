#include "coupling/two_grid/open_nodes.h"

#include <algorithm>

#include "cfd/parallel/ranks.h"

namespace twogrid {

namespace {

constexpr long long kNone = 1LL << 40;  // depth of nodes that belong to no family yet
constexpr long long kDeepest = 2;
constexpr double kSliver = 0.02;  // of a block's open part: what holds less is no part of its own
/// Leftovers that are that open may begin a family before the rest joins what there is, however far.
constexpr double kMayBegin = 0.1;

long long sum_over_ranks(MPI_Comm comm, long long mine) {
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_LONG_LONG, MPI_SUM, comm);
  return mine;
}

Int3 neighbour(const Int3& node, int side) {
  Int3 c = node;
  c[side / 2] += side % 2 ? 1 : -1;
  return c;
}

}  // namespace

/// Which fine cells are open, and their faces, in the blocks of own nodes and those next to them.
struct OpenNodes::FineCells {
  // Bit 0: open; 1 + d: so is its low face normal to d. kAbsent: there is no such cell.
  static constexpr long long kAbsent = 0, kThere = 16, kAllOpen = 31;
  Array3<long long> cell;
  Array3<char> reached;
  std::vector<Int3> frontier;

  FineCells(MPI_Comm comm, const Fluid& fluid, const Int3& ratio) {
    const int rank = rank_of(comm);
    const Layout& layout = fluid.layout();
    const FineGrid& grid = fluid.grid();
    const std::vector<Box> wanted = with_halo(layout.all_cells(), ratio);
    cell.reset(wanted[rank], kAbsent);
    reached.reset(wanted[rank], 0);
    const OpenShares& open = *fluid.open_shares();
    for_each(layout.cells(rank), [&](int i, int j, int k) {
      long long bits = kThere + (open.theta()(i, j, k) > 0);
      const Int3 c{i, j, k};
      for (int d = 0; d < 3; ++d) {
        const bool at_side = !grid.axis[d].periodic() && c[d] == 0;  // leads nowhere, and closes nothing off
        if (at_side || open.alpha(d, open.ratio()[d].index(i, j, k)) > 0) bits += 2 << d;
      }
      cell(i, j, k) = bits;
    });
    BlockExchange(comm, layout.all_cells(), wanted, grid.n(), grid.periodic()).bring<long long>(cell);
  }

  bool all_open(const Box& b) const {
    bool all = true;
    for_each(b, [&](int i, int j, int k) {
      const long long c = cell(i, j, k);
      all = all && (c == kAbsent || c == kAllOpen);
    });
    return all;
  }

  /// Marks what is connected with the marked cells in `frontier` within b.
  void flood(const Box& b) {
    while (!frontier.empty()) {
      const Int3 c = frontier.back();
      frontier.pop_back();
      for (int side = 0; side < 6; ++side) {
        const Int3 next = neighbour(c, side);
        if (!b.contains(next[0], next[1], next[2])) continue;
        const Int3& upper = side % 2 ? next : c;
        if (!(cell(upper[0], upper[1], upper[2]) & 2 << side / 2)) continue;
        mark(next);
      }
    }
  }
  void mark(const Int3& c) {
    char& seen = reached(c[0], c[1], c[2]);
    if (seen || !(cell(c[0], c[1], c[2]) & 1)) return;
    seen = 1;
    frontier.push_back(c);
  }
  /// Connected sets of open cells in b, one of the rank's own blocks, that hold more than a sliver: a wall that just
  /// touches the block leaves some of those at its corners.
  int sets(const Box& b, const CellField<FineGrid>& theta) {
    const auto marked = [&] {
      double sum = 0;
      for_each(b, [&](int i, int j, int k) { sum += reached(i, j, k) ? theta(i, j, k) : 0.0; });
      return sum;
    };
    double all = 0, before = 0;
    for_each(b, [&](int i, int j, int k) { all += theta(i, j, k); });
    int n = 0;
    for_each(b, [&](int i, int j, int k) {
      mark({i, j, k});
      if (frontier.empty()) return;
      flood(b);
      const double now = marked();
      n += now - before > kSliver * all;
      before = now;
    });
    for_each(b, [&](int i, int j, int k) { reached(i, j, k) = 0; });
    return n;
  }
  /// An open cell of one is connected with one of the other within the box that both span.
  bool connected(const Box& one, const Box& other) {
    Box both;
    for (int d = 0; d < 3; ++d)
      both.lo[d] = std::min(one.lo[d], other.lo[d]), both.hi[d] = std::max(one.hi[d], other.hi[d]);
    for_each(one, [&](int i, int j, int k) { mark({i, j, k}); });
    flood(both);
    bool found = false;
    for_each(other, [&](int i, int j, int k) { found = found || reached(i, j, k); });
    for_each(both, [&](int i, int j, int k) { reached(i, j, k) = 0; });
    return found;
  }
};

OpenNodes::OpenNodes(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid, const Int3& search)
    : search_(search) {
  const Layout nodes = node_layout(fluid.layout(), grid);
  const std::vector<Box> wanted = with_halo(nodes.all_cells(), {1, 1, 1});
  own_ = nodes.cells(rank_of(comm));
  with_halo_ = wanted[rank_of(comm)];
  halo_ = BlockExchange(comm, nodes.all_cells(), wanted, grid.n(), grid.periodic());
  measure(fluid, grid);
  look_around(comm, fluid, grid);
  found_families(comm, fluid, grid);
  count(comm, grid);
}

void OpenNodes::measure(const Fluid& fluid, const ParticleGrid& grid) {
  const CellField<FineGrid>& theta = fluid.open_shares()->theta();
  const FineGrid& fine = fluid.grid();
  part_.reset(own_);
  const bool blocks = grid.ratio != Int3{1, 1, 1};
  for (auto& off : off_) off.reset(blocks ? with_halo_ : Box{});
  for_each(own_, [&](int I, int J, int K) {
    bool whole = true;
    double sum = 0;
    Vec3 moment{0, 0, 0};
    const Vec3 centre{grid.axis[0].centre(I), grid.axis[1].centre(J), grid.axis[2].centre(K)};
    for_each(grid.block(I, J, K), [&](int i, int j, int k) {
      const double open = theta(i, j, k), v = open * fine.volume(i, j, k);
      whole = whole && open == 1;
      sum += v;
      const Int3 c{i, j, k};
      for (int d = 0; d < 3; ++d) moment[d] += v * (fine.axis[d].centre(c[d]) - centre[d]);
    });
    part_(I, J, K) = whole ? grid.Grid::volume(I, J, K) : sum;
    for (int d = 0; d < 3 && blocks && sum > 0; ++d) off_[d](I, J, K) = moment[d] / sum;
  });
  if (blocks) halo_.bring<double>({&off_[0], &off_[1], &off_[2]});
}

void OpenNodes::look_around(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid) {
  FineCells cells(comm, fluid, grid.ratio);
  sight_.reset(own_);
  for_each(own_, [&](int I, int J, int K) {
    const Box block = grid.block(I, J, K);
    const bool whole = cells.all_open(block.grown(grid.ratio));
    long long bits = 0;
    if (part_(I, J, K) > 0) {
      bits = kOpen;
      for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
          for (int x = -1; x <= 1; ++x) {
            if (x == 0 && y == 0 && z == 0) continue;
            const Box other = block.shifted({x * grid.ratio[0], y * grid.ratio[1], z * grid.ratio[2]});
            const bool there = cells.cell(other.lo[0], other.lo[1], other.lo[2]) != FineCells::kAbsent;
            if (there && (whole || cells.connected(block, other))) bits += seen(x, y, z);
          }
      if (!whole) figures_.split += cells.sets(block, fluid.open_shares()->theta()) > 1;
    }
    sight_(I, J, K) = bits;
  });
}

void OpenNodes::found_families(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid) {
  const OpenShares& open = *fluid.open_shares();
  const FineGrid& fine = fluid.grid();
  const Int3 n = grid.n();
  // A node next to itself, where one fills a period, is no neighbour.
  for (int side = 0; side < 6; ++side) area_[side].reset(own_);
  for_each(own_, [&](int I, int J, int K) {
    for (int side = 0; side < 6; ++side) {
      const int d = side / 2;
      if (n[d] == 1 || !sees(I, J, K, d, side % 2 ? 1 : -1)) continue;
      Box faces = grid.block(I, J, K);
      (side % 2 ? faces.lo[d] : faces.hi[d]) = side % 2 ? faces.hi[d] : faces.lo[d] + 1;
      if (side % 2) faces.hi[d] = faces.lo[d] + 1;
      double sum = 0;
      for_each(faces, [&](int i, int j, int k) {
        sum += open.alpha(d, open.ratio()[d].index(i, j, k)) * fine.area(d, i, j, k);
      });
      area_[side](I, J, K) = sum;
    }
  });
  Array3<long long> depth(with_halo_, kNone);
  Array3<double> share(with_halo_);  // open part over the whole
  parent_.reset(with_halo_, -1);
  for_each(own_, [&](int I, int J, int K) {
    share(I, J, K) = part_(I, J, K) / grid.Grid::volume(I, J, K);
    if (share(I, J, K) >= kOwnValue) depth(I, J, K) = 0;
  });
  halo_.bring<double>(share);
  join(comm, grid, kDeepest, depth);
  for (const double begin : {kMayBegin, 0.0})
    for (long long founded = 1; founded > 0;) {
      // Of those that have none: the most open one among its neighbours begins a family.
      long long mine = 0;
      Array3<long long> next = depth;
      for_each(own_, [&](int I, int J, int K) {
        const double own = share(I, J, K);
        if (depth(I, J, K) != kNone || own == 0 || own < begin) return;
        for (int side = 0; side < 6; ++side) {
          if (!(area_[side](I, J, K) > 0)) continue;
          Int3 c = neighbour({I, J, K}, side);
          if (depth(c[0], c[1], c[2]) != kNone) continue;
          const double other = share(c[0], c[1], c[2]);
          if (other > own) return;
          // Equal ones: the lower index, in the domain.
          for (int d = 0; d < 3; ++d) c[d] = (c[d] + n[d]) % n[d];
          const Int3 a{K, J, I}, b{c[2], c[1], c[0]};
          if (other == own && b < a) return;
        }
        next(I, J, K) = 0, ++mine;
      });
      depth.swap(next);
      halo_.bring<long long>(depth);
      founded = sum_over_ranks(comm, mine);
      join(comm, grid, begin > 0 ? kDeepest : kNone, depth);
      if (begin > 0 && founded == 0) join(comm, grid, kNone, depth);
    }
  for (auto& a : area_) a = {};
  link(comm, grid, depth);
  parent_ = {};
  family_ = part_;
  total(slot_of(family_));
  volume_ = part_;
  gather_up(slot_of(volume_));
}

/// Nodes without a family join neighbours that lie less deep than `deepest`, layer by layer.
void OpenNodes::join(MPI_Comm comm, const ParticleGrid& grid, long long deepest, Array3<long long>& depth) {
  const Int3 n = grid.n();
  for (long long joined = 1; joined > 0;) {
    halo_.bring<long long>(depth);
    long long mine = 0;
    Array3<long long> next = depth;
    for_each(own_, [&](int I, int J, int K) {
      if (depth(I, J, K) != kNone || part_(I, J, K) == 0) return;
      double most = 0;
      Int3 best{0, 0, 0};
      for (int side = 0; side < 6; ++side) {
        Int3 c = neighbour({I, J, K}, side);
        const double area = area_[side](I, J, K);
        if (!(area > 0) || depth(c[0], c[1], c[2]) >= std::min(deepest, kNone)) continue;
        const long long below = depth(c[0], c[1], c[2]);
        for (int d = 0; d < 3; ++d) c[d] = (c[d] + n[d]) % n[d];
        const Int3 index{c[2], c[1], c[0]};
        if (area < most || (area == most && !(index < best))) continue;
        most = area, best = index;
        parent_(I, J, K) = side, next(I, J, K) = below + 1;
      }
      mine += next(I, J, K) != kNone;
    });
    depth.swap(next);
    joined = sum_over_ranks(comm, mine);
  }
  halo_.bring<long long>(depth);
}

void OpenNodes::link(MPI_Comm comm, const ParticleGrid& grid, const Array3<long long>& depth) {
  halo_.bring<long long>(parent_);
  long long deepest = 0;
  for_each(own_, [&](int I, int J, int K) {
    if (depth(I, J, K) != kNone) deepest = std::max(deepest, depth(I, J, K));
  });
  MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_LONG_LONG, MPI_MAX, comm);
  up_.resize(deepest), down_.resize(deepest);
  const Slot<long long> place{with_halo_, nullptr, 1};
  const Int3 n = grid.n();
  for_each(own_, [&](int I, int J, int K) {
    const std::ptrdiff_t here = place.index(I, J, K);
    const long long own = depth(I, J, K);
    if (own == kNone) return;
    for (int side = 0; side < 6; ++side) {
      const Int3 c = neighbour({I, J, K}, side);
      if (n[side / 2] > 1 && parent_(c[0], c[1], c[2]) == (side ^ 1))
        up_[own].push_back({here, place.index(c[0], c[1], c[2])});
    }
    if (own == 0) return;
    const Int3 c = neighbour({I, J, K}, int(parent_(I, J, K)));
    down_[own - 1].push_back({here, place.index(c[0], c[1], c[2])});
  });
}

template <class T>
void OpenNodes::pass(const Slot<T>& node, bool up, bool down) const {
  if (up_.empty()) return;
  std::vector<T> all(with_halo_.count());
  const Slot<T> slot{with_halo_, all.data(), 1};
  for_each(own_, [&](int i, int j, int k) { all[slot.index(i, j, k)] = node.data[node.stride * node.index(i, j, k)]; });
  const int depth = int(up_.size());
  for (int l = depth - 1; up && l >= 0; --l) {
    halo_.bring(std::vector<Slot<T>>{slot}, std::vector<Slot<T>>{slot});
    for (const Link& k : up_[l]) all[k.to] += all[k.from];
  }
  if (!down)
    for (const auto& level : down_)
      for (const Link& k : level) all[k.to] = T{};
  for (int l = 0; down && l < depth; ++l) {
    halo_.bring(std::vector<Slot<T>>{slot}, std::vector<Slot<T>>{slot});
    for (const Link& k : down_[l]) all[k.to] = all[k.from];
  }
  for_each(own_, [&](int i, int j, int k) { node.data[node.stride * node.index(i, j, k)] = all[slot.index(i, j, k)]; });
}

template void OpenNodes::pass(const Slot<double>&, bool, bool) const;
template void OpenNodes::pass(const Slot<long long>&, bool, bool) const;
template void OpenNodes::pass(const Slot<FourNumbers>&, bool, bool) const;
template void OpenNodes::pass(const Slot<FourWholeNumbers>&, bool, bool) const;

void OpenNodes::average(Array3<double>& node) const {
  if (up_.empty()) return;
  Array3<double> sum(own_);
  for_each(own_, [&](int i, int j, int k) { sum(i, j, k) = part_(i, j, k) * node(i, j, k); });
  total(slot_of(sum));
  for_each(own_, [&](int i, int j, int k) {
    if (in_family(i, j, k)) node(i, j, k) = sum(i, j, k) / family_(i, j, k);
  });
}

void OpenNodes::count(MPI_Comm comm, const ParticleGrid& grid) {
  for_each(own_, [&](int i, int j, int k) {
    const double whole = grid.Grid::volume(i, j, k), part = part_(i, j, k);
    figures_.cut += part != whole;
    figures_.closed += part == 0;
    figures_.merged += part > 0 && volume_(i, j, k) == 0;
    if (volume_(i, j, k) > 0) figures_.smallest = std::min(figures_.smallest, volume_(i, j, k) / whole);
  });
  for (long long* n : {&figures_.cut, &figures_.closed, &figures_.merged, &figures_.split})
    *n = sum_over_ranks(comm, *n);
  MPI_Allreduce(MPI_IN_PLACE, &figures_.smallest, 1, MPI_DOUBLE, MPI_MIN, comm);
}

}  // namespace twogrid
