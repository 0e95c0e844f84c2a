#include "cfd/measures/grid_measures.h"

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

GridMeasures::GridMeasures(const FineGrid& grid, const Box& own, const Box& local)
    : empty_(own.empty()), local_(local) {
  for (int d = 0; d < 3; ++d) {
    AxisMeasure& m = axis_[d];
    const Axis& a = grid.axis[d];
    m.lo = own.lo[d] - 2;  // even where the fields have no halo
    for (int i = m.lo; i < own.hi[d] + 2; ++i) {
      m.width_.push_back(a.width(i));
      m.face_width_.push_back(a.face_width(i));
      m.inverse_width_.push_back(1 / a.width(i));
      m.inverse_face_width_.push_back(1 / a.face_width(i));
      m.above_share_.push_back(a.width(i) / (a.width(i - 1) + a.width(i)));
      const bool below_in = a.periodic() || i - 1 >= 0, above_in = a.periodic() || i < a.n();
      m.half_below_.push_back(below_in ? 0.5 * a.width(i - 1) : 0.0);
      m.half_above_.push_back(above_in ? 0.5 * a.width(i) : 0.0);
    }
  }
}

namespace {

/// f = the mean of two neighbouring cells with the given share of the upper one.
template <bool varies>
inline void mean_row(const double* e, std::ptrdiff_t s, AlongRow<varies> share, int n, double* f) {
  for (int i = 0; i < n; ++i) f[i] = e[i - s] + share[i] * (e[i] - e[i - s]);
}

TWOGRID_VECTORISED void mean_rows(const Array3<double>& eps, int c, const Box& b, const double* share,
                                  Array3<double>& out) {
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      const std::ptrdiff_t m = eps.index(b.lo[0], j, k), s = eps.stride(c);
      const double* e = eps.data() + m;
      double* f = out.data() + m;
      if (c == 0)
        mean_row(e, s, AlongRow<true>{share}, b.size(0), f);
      else
        mean_row(e, s, AlongRow<false>{share + (c == 1 ? j - b.lo[1] : k - b.lo[2])}, b.size(0), f);
    }
}

}  // namespace

void GridMeasures::face_mean(const CellField<FineGrid>& eps, FaceField<FineGrid>& eps_f) const {
  if (empty_) return;
  for (int c = 0; c < 3; ++c) {
    Box b = local_;
    if (eps.stride(c) > 0) ++b.lo[c];
    mean_rows(eps, c, b, &axis_[c].above_share_[b.lo[c] - axis_[c].lo], eps_f[c]);
  }
}

}  // namespace twogrid
