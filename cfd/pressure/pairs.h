// Which cells of a multigrid level merge into those of the next coarser one. Only geometry decides.
#pragma once

#include <array>
#include <vector>

namespace twogrid {

/// One direction of a level: nodes, and where bricks begin and end.
struct Line {
  std::vector<double> node;
  std::vector<int> cut;

  int n() const { return int(node.size()) - 1; }
  /// Between the centres of cells i and i + 1.
  double distance(int i) const { return 0.5 * (node[i + 2] - node[i]); }
};

using Lines = std::array<Line, 3>;
using Parents = std::array<std::vector<int>, 3>;  ///< of every cell of each direction

/// The pairs of the next level, or empty lists when no two cells may be merged: neighbours of one brick up to `stretch`
/// times the smallest distance of any two, more only as far as is needed to leave at most the share `shrink` of cells.
Parents choose_pairs(const Lines& lines, double stretch, double shrink);
/// The line of the pairs.
Line coarse_line(const Line& fine, const std::vector<int>& parent);

}  // namespace twogrid
