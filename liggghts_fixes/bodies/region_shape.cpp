#include "liggghts_fixes/bodies/region_shape.h"

#include <region.h>

#include <algorithm>
#include <cmath>

namespace twogrid {

using LAMMPS_NS::Region;

namespace {

constexpr int kSamples = 4;     // of an edge
constexpr int kRaySamples = 8;  // of what is near
constexpr double kNowhere = 1e300;

Vec3 along(const Vec3& x, const Vec3& direction, double t) {
  return {x[0] + t * direction[0], x[1] + t * direction[1], x[2] + t * direction[2]};
}
double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 unit(const Vec3& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

/// Two unit vectors across n.
void across(const Vec3& n, Vec3& e, Vec3& f) {
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(n[d]) < std::abs(n[least])) least = d;
  Vec3 axis{0, 0, 0};
  axis[least] = 1;
  e = unit(cross(n, axis));
  f = cross(n, e);
}

}  // namespace

RegionShape::RegionShape(Region& region, const FineGrid& grid) : region_(region) {
  Vec3 from, to;
  RegionShape::bounds(from, to);
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    const double in = 1e-9 * a.length();
    const bool sticks_out = from[d] <= to[d] && (from[d] < a.lo() - in || to[d] > a.hi() + in);
    sides_[d] = {a.lo(), a.hi(), in, a.periodic() && !sticks_out, false, false};
    if (a.periodic()) continue;
    sides_[d].ends_low = ends_at(d, a.lo(), in, grid), sides_[d].ends_high = ends_at(d, a.hi(), -in, grid);
  }
}

/// Whether somewhere the region begins or ends in a plane across d.
bool RegionShape::ends_at(int d, double plane, double inwards, const FineGrid& grid) const {
  constexpr int kLooks = 48;  // in each direction
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  for (int i = 0; i < kLooks; ++i)
    for (int j = 0; j < kLooks; ++j) {
      Vec3 in, out;
      in[d] = plane + inwards, out[d] = plane - inwards;
      in[e] = out[e] = grid.axis[e].lo() + (i + 0.5) / kLooks * grid.axis[e].length();
      in[f] = out[f] = grid.axis[f].lo() + (j + 0.5) / kLooks * grid.axis[f].length();
      if (region_.match(in[0], in[1], in[2]) != region_.match(out[0], out[1], out[2])) return true;
    }
  return false;
}

bool RegionShape::solid(const Vec3& x) const {
  double at[3];
  for (int d = 0; d < 3; ++d) {
    const Sides& s = sides_[d];
    at[d] = x[d];
    if (s.wraps) at[d] -= std::floor((at[d] - s.lo) / (s.hi - s.lo)) * (s.hi - s.lo);
    if (s.wraps || s.ends_low) at[d] = std::max(at[d], s.lo + s.inwards);
    if (s.wraps || s.ends_high) at[d] = std::min(at[d], s.hi - s.inwards);
  }
  return region_.match(at[0], at[1], at[2]) != 0;
}

/// Where from x along the direction, between two distances, the region first begins or ends; kNowhere if it doesn't.
double RegionShape::first_change(const Vec3& x, const Vec3& direction, double from, double to, int samples) const {
  const bool begins = solid(along(x, direction, from));
  double lo = from;
  for (int i = 1; i <= samples; ++i) {
    double hi = i == samples ? to : from + (to - from) * i / samples;
    if (solid(along(x, direction, hi)) == begins) {
      lo = hi;
      continue;
    }
    const double enough = 1e-14 * std::abs(to);
    while (std::abs(hi - lo) > enough) {
      const double middle = 0.5 * (lo + hi);
      if (middle == lo || middle == hi) break;
      (solid(along(x, direction, middle)) == begins ? lo : hi) = middle;
    }
    return 0.5 * (lo + hi);
  }
  return kNowhere;
}

double RegionShape::first_crossing(const Vec3& x, int d, double length) const {
  Vec3 direction{0, 0, 0};
  direction[d] = 1;
  const double t = first_change(x, direction, 0, length, kSamples);
  return t == kNowhere ? kNone : std::clamp(t / length, 0.0, 1.0);
}

/// Of the surface that is met at t: by two rays beside. False at an edge.
bool RegionShape::normal_at(const Vec3& x, const Vec3& direction, double t, double step, Vec3& normal) const {
  Vec3 e, f;
  across(direction, e, f);
  Vec3 at[2];
  for (int q = 0; q < 2; ++q) {
    const Vec3& beside = q == 0 ? e : f;
    const Vec3 from = along(x, beside, step);
    const double near = first_change(from, direction, t - 4 * step, t + 4 * step, kSamples);
    if (near == kNowhere) return false;
    at[q] = along(along({0, 0, 0}, beside, step), direction, near - t);
  }
  normal = cross(at[0], at[1]);
  if (!(dot(normal, normal) > 0)) return false;
  normal = unit(normal);
  if (dot(normal, direction) < 0) normal = {-normal[0], -normal[1], -normal[2]};
  return true;
}

double RegionShape::distance(const Vec3& x, double reach, Vec3& nearest) const {
  double best = kNowhere;
  Vec3 way{0, 0, 0};
  const auto look = [&](const Vec3& direction) {
    const double t = first_change(x, direction, 0, std::min(best, reach), kRaySamples);
    if (!(t < best)) return false;
    best = t, way = direction;
    return true;
  };
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if (i != 0 || j != 0 || k != 0) look(unit({double(i), double(j), double(k)}));
  if (best == kNowhere) return 2 * reach;
  // The way to the nearest point is the normal there.
  bool found = false;
  for (int tries = 0; tries < 12 && !found; ++tries) {
    Vec3 normal;
    if (!normal_at(x, way, best, 1e-4 * reach, normal)) break;
    found = dot(normal, way) > 1 - 1e-12;
    if (!found && !look(normal)) break;
  }
  // Edges, and what the normals don't lead to: by ways aside, ever less.
  for (double tilt = 0.2; !found && tilt > 0.005; tilt /= 2) {
    for (int moves = 0; moves < 4; ++moves) {
      Vec3 e, f;
      across(way, e, f);
      const Vec3 from = way;
      bool nearer = false;
      for (double sign : {1.0, -1.0})
        for (const Vec3* beside : {&e, &f}) nearer = look(unit(along(from, *beside, sign * tilt))) || nearer;
      if (!nearer) break;
    }
  }
  nearest = along(x, way, best);
  return best;
}

void RegionShape::bounds(Vec3& lo, Vec3& hi) const {
  if (!region_.bboxflag || !region_.interior) return SolidShape::bounds(lo, hi);
  lo = {region_.extent_xlo, region_.extent_ylo, region_.extent_zlo};
  hi = {region_.extent_xhi, region_.extent_yhi, region_.extent_zhi};
}

}  // namespace twogrid
