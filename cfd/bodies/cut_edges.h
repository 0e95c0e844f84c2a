// Where the grid's edges meet the surfaces, and which vertices lie on one.
#pragma once

#include <array>
#include <vector>

#include "cfd/bodies/local_grid.h"
#include "cfd/bodies/surfaces.h"

namespace twogrid {

/// An edge's first crossings from its two ends: shares of its length from the low end, and from the high end.
struct Crossing {
  double low, high;
  int body_low, body_high;
  bool single() const { return low + high > 1 - 1e-6; }
};

class CutEdges {
 public:
  CutEdges(const LocalGrid& grid, const Surfaces& surfaces);

  /// Of the edge from a vertex up along d; null: not crossed.
  const Crossing* at(int d, int i, int j, int k) const {
    const int m = place_[d](i, j, k);
    return m < 0 ? nullptr : &crossing_[m];
  }
  bool on_surface(int i, int j, int k) const { return on_(i, j, k) != 0; }
  /// True where the cell has a crossed edge or a corner on a surface.
  bool touches(const Int3& cell) const;
  /// Which corners of a face an uncrossed way along the axes joins to its centre: bit e + 2 f, e and f 0 or 1 the
  /// corner's place in the two directions that follow d.
  unsigned joined_corners(int d, const Int3& face) const;

 private:
  void find(const Box& block);
  void cross(int d, const Int3& low);

  const LocalGrid& grid_;
  const Surfaces& surfaces_;
  std::array<Array3<int>, 3> place_;
  Array3<unsigned char> on_;
  std::vector<Crossing> crossing_;
};

}  // namespace twogrid
