// Index boxes and the arrays that live on them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace twogrid {

using Int3 = std::array<int, 3>;
using Vec3 = std::array<double, 3>;

/// Half-open box of global indices, lo <= (i,j,k) < hi. A box with hi <= lo in any direction is empty.
struct Box {
  Int3 lo{0, 0, 0};
  Int3 hi{0, 0, 0};

  int size(int d) const { return std::max(0, hi[d] - lo[d]); }
  std::size_t count() const { return std::size_t(size(0)) * size(1) * size(2); }
  bool empty() const { return count() == 0; }
  bool contains(int i, int j, int k) const {
    return i >= lo[0] && i < hi[0] && j >= lo[1] && j < hi[1] && k >= lo[2] && k < hi[2];
  }
  /// Enlarged by g indices on every side.
  Box grown(int g) const { return grown(Int3{g, g, g}); }
  Box grown(const Int3& g) const {
    Box b = *this;
    for (int d = 0; d < 3; ++d) b.lo[d] -= g[d], b.hi[d] += g[d];
    return b;
  }
  Box shifted(const Int3& s) const {
    Box b = *this;
    for (int d = 0; d < 3; ++d) b.lo[d] += s[d], b.hi[d] += s[d];
    return b;
  }
  bool operator==(const Box& o) const { return lo == o.lo && hi == o.hi; }
};

/// Boxes with a halo: so many indices more below and above; empty ones stay as they are.
inline std::vector<Box> with_halo(std::vector<Box> boxes, const Int3& below, const Int3& above) {
  for (Box& b : boxes)
    if (!b.empty())
      for (int d = 0; d < 3; ++d) b.lo[d] -= below[d], b.hi[d] += above[d];
  return boxes;
}
inline std::vector<Box> with_halo(const std::vector<Box>& boxes, const Int3& width) {
  return with_halo(boxes, width, width);
}

inline Box intersect(const Box& a, const Box& b) {
  Box c;
  for (int d = 0; d < 3; ++d) c.lo[d] = std::max(a.lo[d], b.lo[d]), c.hi[d] = std::min(a.hi[d], b.hi[d]);
  return c;
}

/// Values on a box, addressed by global index; i (x) varies fastest. A box one index deep in y or z stands for all
/// indices there: its neighbours in that direction are itself, and need no memory.
template <class T>
class Array3 {
 public:
  Array3() = default;
  explicit Array3(const Box& box, T value = T{}) { reset(box, value); }

  void reset(const Box& box, T value = T{}) {
    box_ = box;
    row_ = box.size(1) == 1 ? 0 : box.size(0);
    slab_ = box.size(2) == 1 ? 0 : std::ptrdiff_t(box.size(0)) * box.size(1);
    data_.assign(box.count(), value);
    origin_ = -(box.lo[0] + std::ptrdiff_t(row_) * box.lo[1] + slab_ * box.lo[2]);
  }
  void fill(T value) { std::fill(data_.begin(), data_.end(), value); }

  const Box& box() const { return box_; }
  std::ptrdiff_t index(int i, int j, int k) const { return origin_ + i + std::ptrdiff_t(row_) * j + slab_ * k; }
  T& operator()(int i, int j, int k) { return data_[index(i, j, k)]; }
  T operator()(int i, int j, int k) const { return data_[index(i, j, k)]; }
  /// Distance in memory between neighbours in direction d.
  std::ptrdiff_t stride(int d) const { return d == 0 ? 1 : d == 1 ? row_ : slab_; }
  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  std::size_t size() const { return data_.size(); }
  void swap(Array3& o) {
    std::swap(box_, o.box_);
    std::swap(row_, o.row_);
    std::swap(slab_, o.slab_);
    std::swap(origin_, o.origin_);
    data_.swap(o.data_);
  }

 private:
  Box box_;
  int row_ = 0;
  std::ptrdiff_t slab_ = 0, origin_ = 0;
  std::vector<T> data_;
};

/// Calls f(i,j,k) for every index of the box, x fastest.
template <class F>
inline void for_each(const Box& b, F&& f) {
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j)
      for (int i = b.lo[0]; i < b.hi[0]; ++i) f(i, j, k);
}

}  // namespace twogrid
