// Measures seen from a row along x, for loops over contiguous values.
#pragma once

#include <vector>

#include "cfd/measures/grid_measures.h"
#include "cfd/measures/open_rows.h"

namespace twogrid {

/// A measure of one direction, seen from a row along x: it varies along the row if the direction is x, else it is one
/// number.
template <bool varies>
struct AlongRow {
  const double* first;
  double operator[](int i) const { return varies ? first[i] : *first; }
};

/// The values of `a`, one an index of direction dir, from element i on along a row.
template <int dir>
inline AlongRow<dir == 0> along_row(const std::vector<double>& a, int i) {
  return {&a[i]};
}

/// Measures of a row of faces normal to d from (i,j,k) on.
template <int d>
struct RowMeasure {
  static constexpr int e = (d + 1) % 3, f = (d + 2) % 3;
  AlongRow<d == 0> below, above, inverse_width;
  AlongRow<e == 0> we;
  AlongRow<f == 0> wf;

  RowMeasure(const GridMeasures& m, const Int3& x)
      : below(along_row<d>(m.axis(d).half_below_, x[d] - m.axis(d).lo)),
        above(along_row<d>(m.axis(d).half_above_, x[d] - m.axis(d).lo)),
        inverse_width(along_row<d>(m.axis(d).inverse_face_width_, x[d] - m.axis(d).lo)),
        we(along_row<e>(m.axis(e).width_, x[e] - m.axis(e).lo)),
        wf(along_row<f>(m.axis(f).width_, x[f] - m.axis(f).lo)) {}
  double area(int t) const { return we[t] * wf[t]; }
  double volume(int t) const { return (below[t] + above[t]) * we[t] * wf[t]; }
};

/// Measures of a row of cells from (i,j,k) on: areas of their faces, volume.
struct CellRowMeasure {
  const double* wx;
  double wy, wz;

  CellRowMeasure(const GridMeasures& m, const Int3& x)
      : wx(&m.axis(0).width_[x[0] - m.axis(0).lo]), wy(m.axis(1).width(x[1])), wz(m.axis(2).width(x[2])) {}
  double area_x(int) const { return wy * wz; }
  double area_y(int t) const { return wz * wx[t]; }
  double area_z(int t) const { return wx[t] * wy; }
  double volume(int t) const { return wx[t] * wy * wz; }
};

/// Calls f(first index of the row, its memory index in `like`, its length) for each row of the box. open: parts of the
/// box's rows; null: whole rows.
template <class F>
inline void for_each_row(const Box& b, const OpenRows* open, const Array3<double>& like, F&& f) {
  if (!open) {
    const int n = b.size(0);
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) f(Int3{b.lo[0], j, k}, like.index(b.lo[0], j, k), n);
    return;
  }
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      const OpenRows::Part part = open->at(j, k);
      if (part.size() > 0) f(Int3{part.begin, j, k}, like.index(part.begin, j, k), part.size());
    }
}

}  // namespace twogrid
