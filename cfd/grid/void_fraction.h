// eps(t) over one coupling interval, as the fluid's sub-steps see it.
#pragma once

#include <algorithm>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"

namespace twogrid {

/// Cubic Hermite in time between eps at the interval's ends with given slopes there, so that d(eps)/dt is continuous
/// from one interval to the next; where slopes are so steep that the curve would dip below half of the smaller end, it
/// stops there. Linear when the slopes are both (end - begin)/interval. The slope at the end follows from the interval's
/// rate s = (end - begin)/interval and the last interval's: s + extrapolation (s - rate_before).
/// The cell fields have the fluid's halo (fluid.h), beyond the domain's sides too.
struct VoidFractionInTime {
  const CellField<FineGrid>* begin = nullptr;
  const CellField<FineGrid>* end = nullptr;
  const CellField<FineGrid>* slope_begin = nullptr;  ///< 1/s; null: linear
  const CellField<FineGrid>* rate_before = nullptr;  ///< 1/s; wanted with slope_begin
  double extrapolation = 0;

  /// eps at fraction s in [0,1] of an interval of length dt, at memory index m.
  double at(std::ptrdiff_t m, double s, double dt) const {
    const double e0 = begin->data()[m], e1 = end->data()[m];
    if (!slope_begin || s == 1.0) return e0 + s * (e1 - e0);
    const double d0 = slope_begin->data()[m] * dt, d1 = end_slope(m, dt) * dt;
    const double r = 1 - s;
    const double smooth = e0 + (e1 - e0) * s * s * (3 - 2 * s) + d0 * s * r * r - d1 * s * s * r;
    return std::max(smooth, 0.5 * std::min(e0, e1));
  }
  /// Slope at the end (1/s), of an interval of length dt with slopes.
  double end_slope(std::ptrdiff_t m, double dt) const {
    const double s = (end->data()[m] - begin->data()[m]) / dt;
    return s + extrapolation * (s - rate_before->data()[m]);
  }
};

}  // namespace twogrid
