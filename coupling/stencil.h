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

/// The two nodes a direction between whose centres a particle lies, eight in all.
struct Corners {
  double w[3];        ///< weight of the upper node; the lower one has the rest
  std::ptrdiff_t at;  ///< place of the lowest of the eight in a field of the window
  int upper;          ///< bit d: there is an upper node in direction d (else w = 0)

  /// What to add to `at` for the upper node of direction d.
  template <class T>
  std::ptrdiff_t up(const Array3<T>& shape, int d) const {
    return (upper >> d & 1) * shape.stride(d);
  }
};

/// f(place, weight) for the eight nodes, x varies fastest.
template <class T, class F>
inline void for_corners(const Corners& c, const Array3<T>& shape, F f) {
  const std::ptrdiff_t x = c.up(shape, 0), y = c.up(shape, 1), z = c.up(shape, 2);
  const double x0 = 1 - c.w[0], y0 = 1 - c.w[1], z0 = 1 - c.w[2];
  const double yz[4] = {y0 * z0, c.w[1] * z0, y0 * c.w[2], c.w[1] * c.w[2]};
  const std::ptrdiff_t row[4] = {c.at, c.at + y, c.at + z, c.at + y + z};
  for (int k = 0; k < 4; ++k) {
    f(row[k], x0 * yz[k]);
    f(row[k] + x, c.w[0] * yz[k]);
  }
}

template <int N>
inline void gather(const Corners& c, const Array3<double>& shape, const double* const (&field)[N], double* out) {
  for (int q = 0; q < N; ++q) out[q] = 0;
  for_corners(c, shape, [&](std::ptrdiff_t m, double w) {
    for (int q = 0; q < N; ++q) out[q] += w * field[q][m];
  });
}

/// As scatter() below.
inline void scatter(const Corners& c, long long total, Array3<long long>& field) {
  long long* const to = field.data();
  const double q = double(total);
  long long rest = total;
  for_corners(c, field, [&](std::ptrdiff_t m, double w) {
    const long long part = static_cast<long long>(w * q);
    to[m] += part;
    rest -= part;
  });
  std::ptrdiff_t largest = c.at;
  for (int d = 0; d < 3; ++d) largest += int(c.w[d] > 0.5) * c.up(field, d);
  to[largest] += rest;
}

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
