// A surface of triangles, of any orientation, closed or not.
#pragma once

#include <array>
#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/grid.h"

namespace twogrid {

using Triangle = std::array<Vec3, 3>;

/// A line along an axis meets each edge and each corner that triangles share as it meets one surface: once where it goes
/// through, however it is rounded (signs are exact, ties as if the line lay a little higher in both directions). Cost of
/// a question: that of the few triangles near it.
class TriangleSet : public SolidShape {
 public:
  /// Throws std::invalid_argument without a triangle that has an area, and where a corner is not finite.
  explicit TriangleSet(const std::vector<Triangle>& triangles);

  double first_crossing(const Vec3& x, int d, double length) const override;
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  void bounds(Vec3& lo, Vec3& hi) const override { lo = lo_, hi = hi_; }

  const std::vector<Triangle>& triangles() const { return triangle_; }

 private:
  void set_bins();
  /// Whether a triangle is nearer than the root of `square`, within a box of the given reach; puts its place.
  bool nearest_within(const Vec3& x, double reach, double& square, Vec3& nearest) const;
  /// Calls f(bin) for the bins that a triangle touches.
  template <class F>
  void for_each_bin(const Triangle& t, F&& f) const;
  int bin_along(int d, double x) const;  ///< clamped
  std::size_t bin(int i, int j, int k) const {
    return std::size_t(i) + std::size_t(bins_[0]) * (std::size_t(j) + std::size_t(bins_[1]) * std::size_t(k));
  }

  std::vector<Triangle> triangle_;
  std::vector<Vec3> normal_;  // of size 1
  Vec3 lo_, hi_;
  Int3 bins_{1, 1, 1};
  Vec3 bin_lo_{0, 0, 0}, bin_width_{1, 1, 1};
  std::vector<int> start_, member_;  // triangles of bin b: member_[start_[b]] ... member_[start_[b + 1] - 1]
};

/// The triangles but for those in the plane of a side of the domain that isn't periodic (lids of a vessel at its inlet and
/// outlet): there the side's condition holds. All of them where nothing would be left.
std::vector<Triangle> without_lids(const std::vector<Triangle>& triangles, const FineGrid& grid);

}  // namespace twogrid
