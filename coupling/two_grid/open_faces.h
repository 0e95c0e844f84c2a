// Which faces of a box are solved for, row by row along x, as factors for loops over whole rows. Faces are fixed only
// at sides and inlets, so that most rows have none, and the others share a few patterns.
#pragma once

#include <vector>

#include "cfd/fluid/fluid.h"

namespace twogrid {

class OpenFaces {
 public:
  OpenFaces() = default;
  /// faces: a part of the box of `state`; its state of now is kept.
  OpenFaces(const Array3<FaceState>& state, const Box& faces);

  /// Factors of the row's faces, the box's first one first: 1 solved, 0 fixed. Null: all are solved.
  const double* row(int j, int k) const {
    const int p = pattern_[(j - box_.lo[1]) + std::size_t(box_.size(1)) * (k - box_.lo[2])];
    return p < 0 ? nullptr : &factor_[p];
  }

 private:
  Box box_;
  std::vector<int> pattern_;    // of each row: where it begins in factor_; -1: all solved
  std::vector<double> factor_;  // the patterns that occur, one after the other
};

}  // namespace twogrid
