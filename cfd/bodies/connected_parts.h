// Parts of the grid that are joined, over all ranks: vertices that uncrossed edges join, cells that open faces join.
#pragma once

#include <functional>
#include <vector>

#include "cfd/bodies/local_grid.h"

namespace twogrid {

/// Which items belong to some part at all, and which are joined to the next one up along d.
using IsMember = std::function<bool(int i, int j, int k)>;
using IsJoined = std::function<bool(int d, int i, int j, int k)>;

class ConnectedParts {
 public:
  /// Items: own ones and a halo, which the exchange brings; is_joined is asked of own ones, is_member of all. Collective.
  ConnectedParts(const LocalGrid& grid, const Box& own, const Box& all, const BlockExchange& halo,
                 const IsMember& is_member, const IsJoined& is_joined);

  /// Number of parts in the whole domain. They are in the order of their first items, the same on any number of ranks.
  int count() const { return int(first_.size()); }
  /// Part of an item, own or halo; -1: of none.
  int at(int i, int j, int k) const { return int(part_(i, j, k)); }
  /// LocalGrid::number of a part's first item.
  long long first(int part) const { return first_[part]; }

 private:
  Array3<long long> part_;
  std::vector<long long> first_;
};

/// What all ranks have, one after the other. Collective.
std::vector<long long> gathered(MPI_Comm comm, const std::vector<long long>& mine);

}  // namespace twogrid
