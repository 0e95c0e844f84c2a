#include "cfd/boundary/patches.h"

#include <algorithm>

#include "cfd/grid/pi.h"

namespace twogrid {

bool covers(const PatchShape& shape, int side, const Vec3& x) {
  const int n = direction(side), e = n == 0 ? 1 : 0, f = n == 2 ? 1 : 2;
  const auto& v = shape.value;
  switch (shape.kind) {
    case PatchShape::Kind::kWhole:
      return true;
    case PatchShape::Kind::kRectangle:
      return x[e] > v[0] && x[e] < v[1] && x[f] > v[2] && x[f] < v[3];
    case PatchShape::Kind::kCircle: {
      const double a = x[e] - v[0], b = x[f] - v[1];
      return a * a + b * b < v[2] * v[2];
    }
    case PatchShape::Kind::kRegion:
      return shape.inside && shape.inside(x);
  }
  return false;
}

namespace {

double drawn_area(const PatchShape& shape, const Axis& e, const Axis& f) {
  const auto& v = shape.value;
  switch (shape.kind) {
    case PatchShape::Kind::kWhole:
      return e.length() * f.length();
    case PatchShape::Kind::kRectangle:
      return (std::min(v[1], e.hi()) - std::max(v[0], e.lo())) * (std::min(v[3], f.hi()) - std::max(v[2], f.lo()));
    case PatchShape::Kind::kCircle:
      return kPi * v[2] * v[2];
    case PatchShape::Kind::kRegion:
      return shape.outline && shape.outline->found ? shape.outline->area : -1;
  }
  return -1;
}

}  // namespace

std::vector<PatchSize> patch_sizes(const FluidSettings& fluid, int side, const FineGrid& grid) {
  const auto& conditions = fluid.side[side];
  const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
  std::vector<PatchSize> sizes(conditions.size());
  for (std::size_t c = 0; c < conditions.size(); ++c)
    sizes[c].drawn = drawn_area(conditions[c].shape, grid.axis[e], grid.axis[f]);
  if (conditions.size() <= 1) {
    if (!sizes.empty()) sizes[0].faces = sizes[0].open = sizes[0].drawn;
    return sizes;
  }
  Vec3 x;
  x[d] = is_high(side) ? grid.axis[d].hi() : grid.axis[d].lo();
  for (int b = 0; b < grid.axis[f].n(); ++b)
    for (int a = 0; a < grid.axis[e].n(); ++a) {
      x[e] = grid.axis[e].centre(a), x[f] = grid.axis[f].centre(b);
      const double area = grid.axis[e].width(a) * grid.axis[f].width(b);
      std::size_t top = 0;
      for (std::size_t c = 0; c < conditions.size(); ++c)
        if (covers(conditions[c].shape, side, x)) sizes[c].faces += area, top = c;
      sizes[top].open += area;
    }
  return sizes;
}

}  // namespace twogrid
