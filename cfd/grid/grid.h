// Tensor-product grids. FineGrid (fluid) is declared here; ParticleGrid, whose cells are blocks of fine cells, in
// coupling/two_grid/particle_grid.h. The two are different types, and so are the fields on them (field.h).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

/// One direction of a tensor-product grid: n cells between n + 1 nodes (m, ascending).
/// Widths and centres may be asked for up to `kPad` cells outside [0, n): periodic images where the direction is
/// periodic, mirror images of the first cells where it is not.
class Axis {
 public:
  static constexpr int kPad = 4;

  Axis() = default;
  /// Throws std::invalid_argument when fewer than two nodes are given or they don't ascend.
  Axis(std::vector<double> nodes, bool periodic);

  int n() const { return n_; }
  bool periodic() const { return periodic_; }
  double lo() const { return node_[kPad]; }
  double hi() const { return node_[kPad + n_]; }
  double length() const { return hi() - lo(); }
  double node(int i) const { return node_[i + kPad]; }                         ///< low face of cell i (m)
  double width(int i) const { return node_[i + 1 + kPad] - node_[i + kPad]; }  ///< of cell i (m)
  double centre(int i) const { return 0.5 * (node_[i + kPad] + node_[i + 1 + kPad]); }
  /// Distance between the centres of cells i-1 and i: the width of the momentum volume of face i (m).
  double face_width(int i) const { return centre(i) - centre(i - 1); }
  bool uniform() const { return uniform_; }
  /// Index of the cell that holds coordinate x: lo <= x < hi. Outside, the result is clamped to -1 or n. O(1) when
  /// uniform, O(log n) otherwise.
  int find(double x) const;
  const std::vector<double> nodes() const { return {node_.begin() + kPad, node_.begin() + kPad + n_ + 1}; }

 private:
  int n_ = 0;
  bool periodic_ = false, uniform_ = true;
  double inverse_width_ = 0;
  std::vector<double> node_;  // n + 1 + 2 kPad
};

/// n equal cells, or widths growing by `ratio` from one cell to the next (ratio > 1: finest at lo; < 1: finest at hi).
/// symmetric: finest at both ends, growing to the middle.
std::vector<double> graded_nodes(double lo, double hi, int n, double ratio = 1.0, bool symmetric = false);

/// Product of three axes.
struct Grid {
  std::array<Axis, 3> axis;

  Int3 n() const { return {axis[0].n(), axis[1].n(), axis[2].n()}; }
  Box cells() const { return {{0, 0, 0}, n()}; }
  std::array<bool, 3> periodic() const { return {axis[0].periodic(), axis[1].periodic(), axis[2].periodic()}; }
  double volume(int i, int j, int k) const { return axis[0].width(i) * axis[1].width(j) * axis[2].width(k); }
  /// Area of a face normal to d at transverse indices of (i,j,k).
  double area(int d, int i, int j, int k) const {
    const Int3 c{i, j, k};
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    return axis[e].width(c[e]) * axis[f].width(c[f]);
  }
};

/// The fluid's grid.
struct FineGrid : Grid {};

}  // namespace twogrid
