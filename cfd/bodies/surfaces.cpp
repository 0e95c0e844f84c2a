#include "cfd/bodies/surfaces.h"

#include <cmath>

namespace twogrid {

using Side = SolidShape::Side;

Surfaces::Surfaces(const FineGrid& grid, const std::vector<Body>& bodies, Which which)
    : bodies_(bodies), solid_outside_(bodies.size(), false) {
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (which == Which::kAll || bodies[b].sheet == (which == Which::kSheets)) add_images(grid, int(b));
}

/// The surface itself, and where it sticks out of a periodic side, what comes in at the other one. A surface that goes
/// beyond both sides, or from one to the other, is taken as one that goes on.
void Surfaces::add_images(const FineGrid& grid, int body) {
  const SolidShape& shape = *bodies_[body].shape;
  Image own{&shape, body, {0, 0, 0}, false, {0, 0, 0}, {0, 0, 0}};
  shape.bounds(own.lo, own.hi);
  own.bounded = own.lo[0] <= own.hi[0] && own.lo[1] <= own.hi[1] && own.lo[2] <= own.hi[2];
  images_.push_back(own);
  if (!own.bounded) return;
  for (int d = 0; d < 3; ++d) {
    const Axis& axis = grid.axis[d];
    if (!axis.periodic()) continue;
    const double slack = 1e-6 * axis.length() / axis.n();
    const bool below = own.lo[d] < axis.lo() - slack && own.hi[d] > axis.lo(),
               above = own.hi[d] > axis.hi() + slack && own.lo[d] < axis.hi();
    if (below == above) continue;
    const double by = below ? axis.length() : -axis.length();
    for (std::size_t q = images_.size(); q-- > 0 && images_[q].body == body;) {
      Image next = images_[q];
      next.shift[d] += by, next.lo[d] += by, next.hi[d] += by;
      images_.push_back(next);
    }
  }
  Vec3 outside = own.lo;
  for (int d = 0; d < 3; ++d)
    if (std::isfinite(own.lo[d]) && std::isfinite(own.hi[d]))
      outside[d] -= 0.1 * (own.hi[d] - own.lo[d]);
    else
      outside[d] = 0;
  solid_outside_[body] = shape.side(outside) == Side::kSolid;
}

Surfaces::Hit Surfaces::first_crossing(const Vec3& x, int d, double length) const {
  Hit first;
  const double end = x[d] + length;
  for (const Image& m : images_) {
    if (m.bounded) {
      const double low = std::min(x[d], end), high = std::max(x[d], end);
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      if (low > m.hi[d] || high < m.lo[d] || x[e] < m.lo[e] || x[e] > m.hi[e] || x[f] < m.lo[f] || x[f] > m.hi[f])
        continue;
    }
    const double s = m.shape->first_crossing({x[0] - m.shift[0], x[1] - m.shift[1], x[2] - m.shift[2]}, d, length);
    if (s <= 1 && s < first.share) first = {s, m.body, m.shift};
  }
  return first;
}

Surfaces::Foot Surfaces::nearest(const Vec3& x, double reach) const {
  Foot best{reach, x, -1, {0, 0, 0}};
  for (const Image& m : images_) {
    if (m.bounded) {
      double square = 0;
      for (int d = 0; d < 3; ++d) {
        const double out = std::max({m.lo[d] - x[d], x[d] - m.hi[d], 0.0});
        square += out * out;
      }
      if (square > best.distance * best.distance) continue;
    }
    Vec3 point = x;
    const double far =
        m.shape->distance({x[0] - m.shift[0], x[1] - m.shift[1], x[2] - m.shift[2]}, best.distance, point);
    if (far < best.distance)
      best = {far, {point[0] + m.shift[0], point[1] + m.shift[1], point[2] + m.shift[2]}, m.body, m.shift};
  }
  return best;
}

Side Surfaces::side(const Vec3& x) const {
  bool all_fluid = true;
  for (std::size_t q = 0; q < images_.size();) {
    const int body = images_[q].body;
    bool solid = false, fluid = false, known = true;
    for (; q < images_.size() && images_[q].body == body; ++q) {
      const Vec3& s = images_[q].shift;
      const Side its = images_[q].shape->side({x[0] - s[0], x[1] - s[1], x[2] - s[2]});
      solid = solid || its == Side::kSolid;
      fluid = fluid || its == Side::kFluid;
      known = known && its != Side::kUnknown;
    }
    if (solid && fluid) solid = !solid_outside_[body];
    if (solid) return Side::kSolid;
    all_fluid = all_fluid && known;
  }
  return all_fluid ? Side::kFluid : Side::kUnknown;
}

}  // namespace twogrid
