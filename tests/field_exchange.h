// For tests of the fluid: what particles do to it, with drag given as a field. The fluid gets it row by row, as from the
// coupling.
#pragma once

#include <algorithm>

#include "cfd/fluid/fluid.h"

namespace twogrid {

class FieldExchange : public Interphase {
 public:
  FieldExchange() : rows_(beta) { beta_rows = &rows_; }
  FieldExchange(const FieldExchange&) = delete;
  FieldExchange& operator=(const FieldExchange&) = delete;

  FaceField<FineGrid> beta;  ///< implicit part's coefficient, kg/(m3 s); zero where it has no values

 private:
  struct Rows : FaceRows {
    explicit Rows(const FaceField<FineGrid>& f) : field(f) {}
    void row(int d, int i, int j, int k, int n, double* out) const override {
      const Array3<double>& f = field[d];
      if (f.size() > 0)
        std::copy_n(f.data() + f.index(i, j, k), n, out);
      else
        std::fill_n(out, n, 0.0);
    }
    const FaceField<FineGrid>& field;
  };
  Rows rows_;
};

}  // namespace twogrid
