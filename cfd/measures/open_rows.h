// Which part of each row along x loops over a box have to work on, where bodies close the ends of rows: the corners of the
// box around a round vessel cost nothing then. Without bodies there are no such tables, and rows are whole.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

class OpenRows {
 public:
  /// From index begin to before end; empty where begin == end.
  struct Part {
    int begin, end;
    int size() const { return end - begin; }
  };

  OpenRows() = default;
  /// open(i,j,k): has to be worked on. What lies between such indices of a row is, too, and a few behind them, so that
  /// the length is whole groups, as vector loops like it.
  template <class Open>
  OpenRows(const Box& box, int group, Open&& open) : lo_(box.lo), n1_(box.size(1)) {
    if (box.empty()) return;
    for (auto* parts : {&part_, &bare_}) parts->reserve(std::size_t(n1_) * box.size(2));
    for (int k = box.lo[2]; k < box.hi[2]; ++k)
      for (int j = box.lo[1]; j < box.hi[1]; ++j) {
        int begin = box.lo[0], end = box.hi[0];
        while (begin < end && !open(begin, j, k)) ++begin;
        while (end > begin && !open(end - 1, j, k)) --end;
        bare_.push_back({begin, end});
        part_.push_back(grouped({begin, end}, group, box.lo[0], box.hi[0]));
      }
  }

  const Part& at(int j, int k) const { return part_[(j - lo_[1]) + std::size_t(n1_) * (k - lo_[2])]; }

  /// Without what makes the groups whole.
  const Part& bare(int j, int k) const { return bare_[(j - lo_[1]) + std::size_t(n1_) * (k - lo_[2])]; }

  std::ptrdiff_t count() const {
    std::ptrdiff_t sum = 0;
    for (const Part& p : part_) sum += p.size();
    return sum;
  }

  static Part hull(const Part& a, const Part& b) {
    return a.size() == 0 ? b : b.size() == 0 ? a : Part{std::min(a.begin, b.begin), std::max(a.end, b.end)};
  }
  static constexpr int kDoubles = 4, kFloats = 8;  ///< groups of what 32 bytes hold

 private:
  /// Lengthened to whole groups between lo and hi, as far as there is room.
  static Part grouped(Part p, int group, int lo, int hi) {
    if (p.size() == 0) return {lo, lo};
    const int wanted = (p.size() + group - 1) / group * group;
    p.end = std::min(hi, p.begin + wanted);
    p.begin = std::max(lo, p.end - wanted);
    return p;
  }

  Int3 lo_{0, 0, 0};
  int n1_ = 0;
  std::vector<Part> part_, bare_;
};

}  // namespace twogrid
