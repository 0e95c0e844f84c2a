// Several numbers for each of a rank's own cells, kept together.
#pragma once

#include <cstddef>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

/// Of grid type G. Cells x fastest; the `columns` numbers of a cell lie together.
template <class G>
class CellTable {
 public:
  void reset(const Box& own, int columns) {
    own_ = own, columns_ = columns;
    value_.assign(own.count() * std::size_t(columns), 0.0);
  }
  /// Of a box's cells.
  static std::size_t place(const Box& b, int i, int j, int k) {
    return (i - b.lo[0]) + std::size_t(b.size(0)) * ((j - b.lo[1]) + std::size_t(b.size(1)) * (k - b.lo[2]));
  }
  const Box& own() const { return own_; }
  int columns() const { return columns_; }
  /// The numbers of cell c.
  double* at(std::size_t c) { return value_.data() + c * std::size_t(columns_); }
  const double* at(std::size_t c) const { return value_.data() + c * std::size_t(columns_); }
  double* data() { return value_.data(); }
  const double* data() const { return value_.data(); }
  std::size_t size() const { return value_.size(); }

 private:
  Box own_;
  int columns_ = 0;
  std::vector<double> value_;
};

}  // namespace twogrid
