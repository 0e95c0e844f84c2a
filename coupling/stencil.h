// The nodes that one particle writes to or reads from, and their weights: a product of one short list a direction.
#pragma once

#include "../cfd/box.h"

namespace twogrid {

struct Stencil {
  static constexpr int kMax = 64;  ///< nodes a direction
  Int3 lo;                         ///< first node, an index of the window
  Int3 n;                          ///< nodes a direction
  double w[3][kMax];               ///< weights; each direction's sum is 1

  bool single() const { return n[0] == 1 && n[1] == 1 && n[2] == 1; }
};

/// Weighted means of N fields on one and the same box at once.
template <int N>
inline void gather(const Stencil& s, const Array3<double>& shape, const double* const (&field)[N], double* out) {
  if (s.single()) {
    const std::ptrdiff_t m = shape.index(s.lo[0], s.lo[1], s.lo[2]);
    for (int q = 0; q < N; ++q) out[q] = field[q][m];
    return;
  }
  for (int q = 0; q < N; ++q) out[q] = 0;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j) {
      const double wjk = s.w[1][j] * s.w[2][k];
      const std::ptrdiff_t m = shape.index(s.lo[0], s.lo[1] + j, s.lo[2] + k);
      for (int i = 0; i < s.n[0]; ++i) {
        const double w = s.w[0][i] * wjk;
        for (int q = 0; q < N; ++q) out[q] += w * field[q][m + i];
      }
    }
}

/// Adds `total` units, split by the weights; what rounding leaves over goes to the node of the largest weight, so that
/// exactly `total` is added.
inline void scatter(const Stencil& s, long long total, Array3<long long>& field) {
  const std::ptrdiff_t first = field.index(s.lo[0], s.lo[1], s.lo[2]);
  if (s.single()) {
    field.data()[first] += total;
    return;
  }
  const double q = double(total);
  long long rest = total;
  double largest = -1;
  std::ptrdiff_t at = first;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j) {
      const double wjk = s.w[1][j] * s.w[2][k];
      const std::ptrdiff_t m = field.index(s.lo[0], s.lo[1] + j, s.lo[2] + k);
      for (int i = 0; i < s.n[0]; ++i) {
        const double w = s.w[0][i] * wjk;
        const long long part = static_cast<long long>(w * q);
        field.data()[m + i] += part;
        rest -= part;
        if (w > largest) largest = w, at = m + i;
      }
    }
  field.data()[at] += rest;
}

}  // namespace twogrid
