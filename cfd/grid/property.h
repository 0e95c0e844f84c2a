// A property of the fluid: one number, or a value a cell.
#pragma once

#include "cfd/grid/field.h"

namespace twogrid {

class Property {
 public:
  double number = 0;  ///< everywhere, unless it varies

  bool varies() const { return varies_; }
  const CellField<FineGrid>& field() const { return field_; }
  /// From now on a value a cell; at first the number.
  CellField<FineGrid>& vary(const Box& local) {
    if (!varies_) field_.reset(local, number), varies_ = true;
    return field_;
  }

 private:
  bool varies_ = false;  // on all ranks alike; the field is empty where a rank has no cells
  CellField<FineGrid> field_;
};

}  // namespace twogrid
