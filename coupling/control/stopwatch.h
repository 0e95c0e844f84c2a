// CPU time by part.
#pragma once

#include <ctime>

namespace twogrid {

/// Adds the CPU time of its life to a share.
class Stopwatch {
 public:
  explicit Stopwatch(double& share) : share_(share), start_(std::clock()) {}
  ~Stopwatch() { share_ += double(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  double& share_;
  std::clock_t start_;
};

}  // namespace twogrid
