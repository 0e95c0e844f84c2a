#include "coupling/void_fraction/void_history.h"

#include <algorithm>

namespace twogrid {

VoidHistory::VoidHistory(const Box& box, Interpolate interpolate) : interpolate_(interpolate) {
  now_.reset(box, 1.0);
  next_.reset(box, 1.0);
  if (interpolate_ == Interpolate::kLinear) return;
  rate_.reset(box);
  slope_begin_.reset(box);
}

void VoidHistory::start() {
  now_.swap(next_);
  last_interval_ = 0;
}

VoidFractionInTime VoidHistory::begin(double interval, const CellField<FineGrid>* replaced) {
  interval_ = interval;
  if (replaced)  // the bound keeps eps positive where other particles have made room in the same interval
    for (std::size_t m = 0; m < now_.size(); ++m) {
      double& e = now_.data()[m];
      e = std::clamp(e + replaced->data()[m], 0.5 * std::min(e, next_.data()[m]), 1.0);
    }
  if (interpolate_ == Interpolate::kSmooth && last_interval_ == 0)
    for (std::size_t m = 0; m < now_.size(); ++m)
      slope_begin_.data()[m] = (next_.data()[m] - now_.data()[m]) / interval;
  return path();
}

VoidFractionInTime VoidHistory::path() const {
  VoidFractionInTime eps;
  eps.begin = &now_;
  eps.end = &next_;
  if (interpolate_ == Interpolate::kLinear) return eps;
  eps.slope_begin = &slope_begin_;
  eps.rate_before = &rate_;
  eps.extrapolation = extrapolation(interval_);
  return eps;
}

void VoidHistory::commit() {
  if (interpolate_ == Interpolate::kSmooth) {
    const VoidFractionInTime eps = path();
    for (std::size_t m = 0; m < now_.size(); ++m) {
      slope_begin_.data()[m] = eps.end_slope(std::ptrdiff_t(m), interval_);
      rate_.data()[m] = (next_.data()[m] - now_.data()[m]) / interval_;
    }
  }
  now_.swap(next_);
  last_interval_ = interval_;
}

}  // namespace twogrid
