#include "void_history.h"

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

VoidFractionInTime VoidHistory::begin(double interval, const CellField<FineGrid>* q) {
  interval_ = interval;
  q_ = q;
  VoidFractionInTime eps;
  eps.begin = &now_;
  eps.end = &next_;
  if (interpolate_ == Interpolate::kLinear) return eps;
  const double r = extrapolation(interval);
  const bool first = last_interval_ == 0;
  for (std::size_t m = 0; m < now_.size(); ++m) {
    const double source = q ? q->data()[m] : 0.0;
    const double s = (next_.data()[m] - now_.data()[m]) / interval - source;
    const double begin = first ? s : slope_begin_.data()[m];
    slope_begin_.data()[m] = begin + source;
    slope_end_.data()[m] = s + r * (s - rate_.data()[m]) + source;
    rate_.data()[m] = s;
  }
  eps.slope_begin = &slope_begin_;
  eps.slope_end = &slope_end_;
  return eps;
}

void VoidHistory::commit() {
  now_.swap(next_);
  last_interval_ = interval_;
  if (interpolate_ == Interpolate::kLinear) return;
  slope_begin_.swap(slope_end_);
  if (q_)
    for (std::size_t m = 0; m < slope_begin_.size(); ++m) slope_begin_.data()[m] -= q_->data()[m];
}

}  // namespace twogrid
