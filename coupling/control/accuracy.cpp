#include "coupling/control/accuracy.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

StepControl::StepControl(double wanted, double order, double step, bool free, double least, double most)
    : wanted_(wanted),
      order_(order),
      step_(step),
      least_(least),
      most_(std::max(most, step)),
      free_(free),
      shortest_(step),
      longest_(step) {}

void StepControl::note(double error) {
  ++count_;
  sum_ += error;
  sum_here_ += error;
  if (++here_ < kTogether) return;
  decide(sum_here_ / here_);
  here_ = 0;
  sum_here_ = 0;
}

void StepControl::decide(double error) {
  if (!free_) return;
  if (rounds_of_noise_ > 0) --rounds_of_noise_;
  const double before = step_;
  const double factor = std::clamp(std::pow(wanted_ / std::max(error, 1e-12), 1 / order_), 0.5, 2.0);
  const double expected = longer_step_ > 0 ? std::pow(step_ / longer_step_, order_) : 1;
  if (longer_step_ > 0 && error > 0.5 * (1 + expected) * error_of_longer_) {  // less than half the gain
    step_ = longer_step_;
    rounds_of_noise_ = kPatience;
    longer_step_ = 0;
  } else if (factor < 0.8 && rounds_of_noise_ == 0) {
    longer_step_ = step_;
    error_of_longer_ = error;
    step_ = std::max(least_, step_ * factor);
    if (step_ == before) longer_step_ = 0;
  } else {
    longer_step_ = 0;
    if (factor > 1.25) step_ = std::min(most_, step_ * factor);
  }
  shortest_ = std::min(shortest_, step_);
  longest_ = std::max(longest_, step_);
}

void StepControl::limit(double most) {
  if (!free_) return;
  most_ = std::max(least_, most);
  step_ = std::min(step_, most_);
  shortest_ = std::min(shortest_, step_);
}

Accuracy::Accuracy(double wanted, int every, bool free_every, double cfl, bool free_cfl)
    : wanted_(wanted),
      fluid_(wanted, 2, cfl, free_cfl, kSmallestCfl, kLargestCfl),
      coupling_(wanted, 1, every, free_every, 1, kLargestEvery) {}

double Accuracy::tolerance(double wanted) {
  return std::clamp(1e-4 * wanted, 1e-8, 1e-5);
}

int Accuracy::every() const {
  return int(coupling_.step() + 1e-9);
}

void Accuracy::adjust(double step_error, double coupling_error, double drag_number) {
  ++checks_;
  const double longest = drag_number > 0 ? kLargestDragNumber / drag_number * every() : kLargestEvery;
  coupling_.limit(std::min(longest, double(kLargestEvery)));
  fluid_.note(kMemory * step_error);
  coupling_.note(coupling_error);
  next_check_ = couplings_ + (checks_ < 2 * StepControl::kTogether ? kEarly : kChecked);
}

}  // namespace twogrid
