#include "coupling/void_fraction/solid_limit.h"

#include <cmath>

#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

namespace {

constexpr long long kFar = 1LL << 40;  // no node with room found yet
constexpr int kMaxSweeps = 1000;

long long sum_over_ranks(MPI_Comm comm, long long mine) {
  long long all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_LONG_LONG, MPI_SUM, comm);
  return all;
}

}  // namespace

SolidLimit::SolidLimit(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, EpsBound kind, double eps_min)
    : comm_(comm), grid_(grid), kind_(kind), eps_min_(eps_min) {
  const int rank = rank_of(comm);
  own_ = nodes.cells(rank);
  const std::vector<Box> wanted = with_halo(nodes.all_cells(), {1, 1, 1});
  halo_ = BlockExchange(comm, nodes.all_cells(), wanted, grid.n(), grid.periodic());
  with_halo_ = wanted[rank];
  most_.reset(own_);
}

SolidLimit::Result SolidLimit::operator()(const FixedPoint& scale, Array3<long long>& solid) {
  if (scale.unit() != unit_) {
    unit_ = scale.unit();
    for_each(own_, [&](int i, int j, int k) {
      most_(i, j, k) = static_cast<long long>((1 - eps_min_) * grid_.volume(i, j, k) / unit_);
    });
  }
  Result result;
  long long above_bound = 0;
  for_each(own_, [&](int i, int j, int k) { above_bound += solid(i, j, k) > most_(i, j, k); });
  if (sum_over_ranks(comm_, above_bound) == 0) return result;

  auto excess_volume = [&] {
    double mine = 0, all = 0;
    for_each(own_, [&](int i, int j, int k) {
      const long long e = solid(i, j, k) - most_(i, j, k);
      if (e > 0) mine += scale.value(e);
    });
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm_);
    return all;
  };
  result.displaced = excess_volume();
  if (kind_ == EpsBound::kClip) {
    for_each(own_, [&](int i, int j, int k) { solid(i, j, k) = std::min(solid(i, j, k), most_(i, j, k)); });
    return result;
  }

  if (room_.size() == 0)
    for (auto* a : {&room_, &distance_, &change_}) a->reset(with_halo_);
  while (result.sweeps < kMaxSweeps) {
    for_each(own_, [&](int i, int j, int k) { room_(i, j, k) = most_(i, j, k) - solid(i, j, k); });
    halo_.bring<long long>(room_);
    find_distances();
    bool stuck = true, above = false;
    for_each(own_, [&](int i, int j, int k) {
      if (room_(i, j, k) >= 0) return;
      above = true;
      if (distance_(i, j, k) < kFar) stuck = false;
    });
    const long long movable = sum_over_ranks(comm_, above && !stuck);
    if (movable == 0) break;
    ++result.sweeps;
    change_.fill(0);
    move_once();
    halo_.add<long long>({&change_}, {&solid});
  }
  result.unplaced = excess_volume();
  result.displaced -= result.unplaced;
  // What found no room may lie in members of families on its way.
  if (const OpenNodes* open = grid_.open_nodes()) open->gather_up(slot_of(solid));
  return result;
}

bool SolidLimit::reaches(int i, int j, int k, int d, int side) const {
  const int c = Int3{i, j, k}[d] + side;
  if (!grid_.axis[d].periodic() && (c < 0 || c >= grid_.axis[d].n())) return false;
  const OpenNodes* const open = grid_.open_nodes();
  return !open || open->sees(i, j, k, d, side);
}

void SolidLimit::find_distances() {
  // Bellman-Ford, one layer a round: enough rounds for the widest cluster without room.
  distance_.fill(kFar);
  for_each(own_, [&](int i, int j, int k) {
    if (room_(i, j, k) > 0) distance_(i, j, k) = 0;
  });
  for (long long changed = 1; changed > 0;) {
    halo_.bring<long long>(distance_);
    long long mine = 0;
    for_each(own_, [&](int i, int j, int k) {
      if (room_(i, j, k) > 0) return;
      long long best = distance_(i, j, k);
      for (int d = 0; d < 3; ++d)
        for (int s = -1; s <= 1; s += 2) {
          Int3 c{i, j, k};
          c[d] += s;
          if (!reaches(i, j, k, d, s)) continue;
          best = std::min(best, distance_(c[0], c[1], c[2]) + 1);
        }
      if (best < distance_(i, j, k) && best < kFar) distance_(i, j, k) = best, ++mine;
    });
    changed = sum_over_ranks(comm_, mine);
  }
  halo_.bring<long long>(distance_);
}

void SolidLimit::move_once() {
  for_each(own_, [&](int i, int j, int k) {
    const long long excess = -room_(i, j, k), distance = distance_(i, j, k);
    if (excess <= 0 || distance >= kFar) return;
    std::array<Int3, 6> to;
    std::array<double, 6> share;
    int count = 0;
    double sum = 0;
    for (int d = 0; d < 3; ++d)
      for (int s = -1; s <= 1; s += 2) {
        Int3 c{i, j, k};
        c[d] += s;
        if (!reaches(i, j, k, d, s)) continue;
        if (distance_(c[0], c[1], c[2]) != distance - 1) continue;
        to[count] = c;
        sum += share[count] = distance == 1 ? double(room_(c[0], c[1], c[2])) : 1.0;
        ++count;
      }
    long long rest = excess;
    for (int q = 1; q < count; ++q) {
      const long long part = std::min(rest, static_cast<long long>(double(excess) * (share[q] / sum)));
      change_(to[q][0], to[q][1], to[q][2]) += part;
      rest -= part;
    }
    change_(to[0][0], to[0][1], to[0][2]) += rest;
    change_(i, j, k) -= excess;
  });
}

}  // namespace twogrid
