#include "cfd/bodies/connected_parts.h"

#include <algorithm>
#include <unordered_map>

#include "cfd/parallel/ranks.h"

namespace twogrid {

namespace {

/// Disjoint sets of 0 ... n - 1; the smallest member names its set.
class Sets {
 public:
  explicit Sets(std::size_t n) : up_(n) {
    for (std::size_t m = 0; m < n; ++m) up_[m] = m;
  }
  std::size_t find(std::size_t m) {
    while (up_[m] != m) m = up_[m] = up_[up_[m]];
    return m;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a), b = find(b);
    if (a < b)
      up_[b] = a;
    else
      up_[a] = b;
  }

 private:
  std::vector<std::size_t> up_;
};

void sort_unique(std::vector<long long>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

std::vector<long long> gathered(MPI_Comm comm, const std::vector<long long>& mine) {
  const int n = int(mine.size());
  std::vector<int> counts(ranks_of(comm)), starts(counts.size(), 0);
  MPI_Allgather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  for (std::size_t r = 1; r < counts.size(); ++r) starts[r] = starts[r - 1] + counts[r - 1];
  std::vector<long long> all(starts.back() + counts.back());
  MPI_Allgatherv(mine.data(), n, MPI_LONG_LONG, all.data(), counts.data(), starts.data(), MPI_LONG_LONG, comm);
  return all;
}

ConnectedParts::ConnectedParts(const LocalGrid& grid, const Box& own, const Box& all, const BlockExchange& halo,
                               const IsMember& is_member, const IsJoined& is_joined) {
  part_.reset(all, -1);
  const auto place = [&](int i, int j, int k) {
    return std::size_t(i - own.lo[0]) +
           std::size_t(own.size(0)) * (std::size_t(j - own.lo[1]) + std::size_t(own.size(1)) * (k - own.lo[2]));
  };
  Sets sets(own.count());
  std::vector<std::array<Int3, 2>> over_borders;
  for_each(own, [&](int i, int j, int k) {
    if (!is_member(i, j, k)) return;
    for (int d = 0; d < 3; ++d) {
      Int3 next{i, j, k};
      ++next[d];
      if (!all.contains(next[0], next[1], next[2]) || !is_member(next[0], next[1], next[2]) || !is_joined(d, i, j, k))
        continue;
      if (own.contains(next[0], next[1], next[2]))
        sets.join(place(i, j, k), place(next[0], next[1], next[2]));
      else
        over_borders.push_back({Int3{i, j, k}, next});
    }
  });
  // The parts of each rank, by the numbers of their first items; then those that touch at borders become one.
  std::vector<long long> mine;
  for_each(own, [&](int i, int j, int k) {
    if (!is_member(i, j, k)) return;
    const std::size_t root = sets.find(place(i, j, k));
    const Int3 r{own.lo[0] + int(root % own.size(0)), own.lo[1] + int(root / own.size(0) % own.size(1)),
                 own.lo[2] + int(root / (std::size_t(own.size(0)) * own.size(1)))};
    part_(i, j, k) = grid.number(r[0], r[1], r[2]);
    if (root == place(i, j, k)) mine.push_back(part_(i, j, k));
  });
  halo.bring(part_);
  std::vector<std::array<long long, 2>> touch;
  for (const auto& p : over_borders)
    touch.push_back({part_(p[0][0], p[0][1], p[0][2]), part_(p[1][0], p[1][1], p[1][2])});
  std::sort(touch.begin(), touch.end());
  touch.erase(std::unique(touch.begin(), touch.end()), touch.end());
  std::vector<long long> pairs;
  for (const auto& t : touch) pairs.insert(pairs.end(), t.begin(), t.end());
  std::vector<long long> names = gathered(grid.comm, mine);
  pairs = gathered(grid.comm, pairs);
  sort_unique(names);
  std::unordered_map<long long, std::size_t> index;
  for (std::size_t q = 0; q < names.size(); ++q) index[names[q]] = q;
  Sets whole(names.size());
  for (std::size_t q = 0; q < pairs.size(); q += 2) whole.join(index[pairs[q]], index[pairs[q + 1]]);
  std::vector<long long> number(names.size());
  for (std::size_t q = 0; q < names.size(); ++q) {
    const std::size_t root = whole.find(q);
    if (root == q) first_.push_back(names[q]);
    number[q] = root == q ? (long long)(first_.size()) - 1 : number[root];
  }
  for_each(all, [&](int i, int j, int k) {
    long long& p = part_(i, j, k);
    if (p >= 0) p = number[index[p]];
  });
}

}  // namespace twogrid
