// The surfaces of bodies together, with their images beyond periodic sides.
#pragma once

#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/grid.h"

namespace twogrid {

class Surfaces {
 public:
  enum class Which { kAll, kSolids, kSheets };
  /// Of all bodies or of some; those keep their places in the list. The bodies must outlive this.
  Surfaces(const FineGrid& grid, const std::vector<Body>& bodies, Which which = Which::kAll);

  /// As SolidShape's, of the body that is met first; body -1: none is.
  struct Hit {
    double share = SolidShape::kNone;
    int body = -1;
    Vec3 shift{0, 0, 0};  ///< of the image
  };
  Hit first_crossing(const Vec3& x, int d, double length) const;
  /// As SolidShape's, of the nearest body; body -1: none within reach.
  struct Foot {
    double distance;
    Vec3 point{0, 0, 0};
    int body = -1;
    Vec3 shift{0, 0, 0};
  };
  Foot nearest(const Vec3& x, double reach) const;
  /// Solid where any body says so; fluid where all know that it isn't theirs.
  SolidShape::Side side(const Vec3& x) const;

  const std::vector<Body>& bodies() const { return bodies_; }

 private:
  struct Image {
    const SolidShape* shape;
    int body;
    Vec3 shift;
    bool bounded;
    Vec3 lo, hi;  // of the image
  };
  void add_images(const FineGrid& grid, int body);

  const std::vector<Body>& bodies_;
  std::vector<Image> images_;
  std::vector<bool> solid_outside_;  // of bodies with images
};

}  // namespace twogrid
