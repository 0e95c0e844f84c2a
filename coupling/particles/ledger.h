// What the coupling takes and gives: sums that must cancel, with compensated addition so that the sums themselves don't
// hide an error.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

/// Compensated sum; what an addition loses is found without a branch (Knuth, The Art of Computer Programming 2, 4.2.2).
class Sum {
 public:
  void operator+=(double x) {
    const double t = sum_ + x, seen = t - sum_;
    rest_ += (sum_ - (t - seen)) + (x - seen);
    sum_ = t;
  }
  double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0, rest_ = 0;
};

/// Four such sums at once.
class FourSums {
 public:
  void add(const Four& x) {
    const Four t = sum_ + x, seen = t - sum_;
    rest_ += (sum_ - (t - seen)) + (x - seen);
    sum_ = t;
  }
  void add_to(Sum& total, int which) const {
    total += sum_[which];
    total += rest_[which];
  }

 private:
  Four sum_{0, 0, 0, 0}, rest_{0, 0, 0, 0};
};

/// Momentum exchanged in one interval, and solid volume; this rank's part, then all ranks' together.
struct Ledger {
  std::array<Sum, 3> action;    ///< impulses and kicks that the particles received (kg m/s)
  std::array<Sum, 3> reaction;  ///< received by the fluid
  std::array<Sum, 3> wall;      ///< received by walls: read and reacted where no face is solved
  Sum magnitude;                ///< sum of |impulse| + |kick|, per component
  Sum particle_volume;          ///< sum of V_p (m3)
  Sum inserted_volume;          ///< sum of V_p of particles that are new since the last coupling (m3)
  Sum deposited_volume;         ///< sum over fine cells of (1 - eps) V (m3)

  /// What has to be summed over ranks for balance().
  std::array<double, 7> own() const;
  /// Relative errors from the sums over all ranks.
  struct Balance {
    double momentum_error = 0;   ///< |action + reaction + wall| / magnitude
    double volume_error = 0;     ///< |deposited - particles| / particles
    double solid_volume = 0;     ///< of the particles (m3)
    double inserted_volume = 0;  ///< m3
  };
  static Balance balance(const std::array<double, 7>& all);
};

}  // namespace twogrid
