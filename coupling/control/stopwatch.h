// CPU time by part.
#pragma once

#include <ctime>

namespace twogrid {

/// CPU time of this process so far (s).
inline double cpu_seconds() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

/// Adds the CPU time of its life to a share.
class Stopwatch {
 public:
  explicit Stopwatch(double& share) : share_(share), start_(cpu_seconds()) {}
  ~Stopwatch() { share_ += cpu_seconds() - start_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& share_;
  double start_;
};

}  // namespace twogrid
