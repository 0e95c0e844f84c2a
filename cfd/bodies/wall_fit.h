// A value at a place from values around it: by least squares, as weights that are found once.
#pragma once

#include <array>
#include <vector>

namespace twogrid {

/// Fits sum of coefficient times term to values at points. Terms are of order 1.
class WallFit {
 public:
  static constexpr int kMost = 10;
  explicit WallFit(int terms) : terms_(terms) {}

  void add(double weight, const std::array<double, kMost>& term) { points_.push_back({weight, term}); }
  std::size_t points() const { return points_.size(); }
  /// Of each point's value in the first coefficient. Terms that the points say nothing about, or fewer points than terms:
  /// the later terms stay small: held back by this share of the sum of weights.
  std::vector<double> of_first(double held) const;

 private:
  struct Point {
    double weight;
    std::array<double, kMost> term;
  };
  int terms_;
  std::vector<Point> points_;
};

}  // namespace twogrid
