#include "void_history.h"

#include <algorithm>

namespace twogrid {

VoidHistory::VoidHistory(const Box& box, Interpolate interpolate) : interpolate_(interpolate) {
  now_.reset(box, 1.0);
  next_.reset(box, 1.0);
  if (interpolate_ == Interpolate::kLinear) return;
  rate_.reset(box);
  slope_begin_.reset(box);
  slope_end_.reset(box);
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
  VoidFractionInTime eps;
  eps.begin = &now_;
  eps.end = &next_;
  if (interpolate_ == Interpolate::kLinear) return eps;
  const double r = extrapolation(interval);
  const bool first = last_interval_ == 0;
  for (std::size_t m = 0; m < now_.size(); ++m) {
    const double s = (next_.data()[m] - now_.data()[m]) / interval;
    if (first) slope_begin_.data()[m] = s;
    slope_end_.data()[m] = s + r * (s - rate_.data()[m]);
    rate_.data()[m] = s;
  }
  eps.slope_begin = &slope_begin_;
  eps.slope_end = &slope_end_;
  return eps;
}

void VoidHistory::commit() {
  now_.swap(next_);
  last_interval_ = interval_;
  if (interpolate_ == Interpolate::kSmooth) slope_begin_.swap(slope_end_);
}

}  // namespace twogrid
