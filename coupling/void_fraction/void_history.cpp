#include "coupling/void_fraction/void_history.h"

#include <algorithm>

namespace twogrid {

VoidHistory::VoidHistory(VoidHistoryState& state, const Box& box, Interpolate interpolate)
    : state_(state), interpolate_(interpolate) {
  state_.now.reset(box, 1.0);
  next_.reset(box, 1.0);
  if (interpolate_ == Interpolate::kLinear) return;
  state_.rate.reset(box);
  state_.slope_begin.reset(box);
}

void VoidHistory::start() {
  state_.now.swap(next_);
  state_.interval = 0;
}

VoidFractionInTime VoidHistory::begin(double interval, const CellField<FineGrid>* replaced) {
  interval_ = interval;
  if (replaced)  // the bound keeps eps positive where other particles have made room in the same interval
    for (std::size_t m = 0; m < state_.now.size(); ++m) {
      double& e = state_.now.data()[m];
      e = std::clamp(e + replaced->data()[m], 0.5 * std::min(e, next_.data()[m]), 1.0);
    }
  if (interpolate_ == Interpolate::kSmooth && state_.interval == 0)
    for (std::size_t m = 0; m < state_.now.size(); ++m)
      state_.slope_begin.data()[m] = (next_.data()[m] - state_.now.data()[m]) / interval;
  return path();
}

VoidFractionInTime VoidHistory::path() const {
  VoidFractionInTime eps;
  eps.begin = &state_.now;
  eps.end = &next_;
  if (interpolate_ == Interpolate::kLinear) return eps;
  eps.slope_begin = &state_.slope_begin;
  eps.rate_before = &state_.rate;
  eps.extrapolation = extrapolation(interval_);
  return eps;
}

void VoidHistory::commit() {
  if (interpolate_ == Interpolate::kSmooth) {
    const VoidFractionInTime eps = path();
    for (std::size_t m = 0; m < state_.now.size(); ++m) {
      state_.slope_begin.data()[m] = eps.end_slope(std::ptrdiff_t(m), interval_);
      state_.rate.data()[m] = (next_.data()[m] - state_.now.data()[m]) / interval_;
    }
  }
  state_.now.swap(next_);
  state_.interval = interval_;
}

}  // namespace twogrid
