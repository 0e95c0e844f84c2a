#include "cfd/bodies/triangle_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "cfd/bodies/exact_turn.h"

namespace twogrid {

namespace {

using Point = std::array<double, 2>;

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 minus(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// turn() without ties: as if p lay e higher in the first direction and e^2 in the second, e next to nothing.
int turn_untied(const Point& a, const Point& b, const Point& p) {
  if (const int side = turn(a, b, p)) return side;
  if (a[1] != b[1]) return b[1] < a[1] ? 1 : -1;
  return b[0] > a[0] ? 1 : b[0] < a[0] ? -1 : 0;
}

/// Nearest point of a segment.
Vec3 on_segment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const Vec3 ab = minus(b, a);
  const double s = std::min(std::max(dot(minus(x, a), ab) / dot(ab, ab), 0.0), 1.0);
  return {a[0] + s * ab[0], a[1] + s * ab[1], a[2] + s * ab[2]};
}

/// Nearest point of a triangle: the foot on its plane if that lies in it, else on one of its edges.
Vec3 on_triangle(const Triangle& t, const Vec3& x) {
  const Vec3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
  bool inside = true;
  for (int q = 0; q < 3 && inside; ++q) {
    const Vec3 &a = t[q], &b = t[(q + 1) % 3];
    inside = dot(cross(minus(b, a), minus(x, a)), n) >= 0;
  }
  if (inside) {
    const double s = dot(minus(x, t[0]), n) / dot(n, n);
    return {x[0] - s * n[0], x[1] - s * n[1], x[2] - s * n[2]};
  }
  Vec3 best{0, 0, 0};
  double least = std::numeric_limits<double>::infinity();
  for (int q = 0; q < 3; ++q) {
    const Vec3 p = on_segment(t[q], t[(q + 1) % 3], x), way = minus(p, x);
    if (dot(way, way) < least) least = dot(way, way), best = p;
  }
  return best;
}

}  // namespace

TriangleSet::TriangleSet(const std::vector<Triangle>& triangles) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  lo_ = {kFar, kFar, kFar}, hi_ = {-kFar, -kFar, -kFar};
  for (const Triangle& t : triangles) {
    for (const Vec3& v : t)
      for (double c : v)
        if (!std::isfinite(c)) throw std::invalid_argument("a corner of the mesh's triangles is not a finite number");
    const Vec3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    if (!(dot(n, n) > 0)) continue;
    triangle_.push_back(t);
    const double size = std::sqrt(dot(n, n));
    normal_.push_back({n[0] / size, n[1] / size, n[2] / size});
    for (const Vec3& v : t)
      for (int d = 0; d < 3; ++d) lo_[d] = std::min(lo_[d], v[d]), hi_[d] = std::max(hi_[d], v[d]);
  }
  if (triangle_.empty()) throw std::invalid_argument("the mesh has no triangle with an area");
  set_bins();
}

/// Some sixteen bins a triangle, of which a surface fills few.
void TriangleSet::set_bins() {
  Vec3 size;
  double longest = 0;
  for (int d = 0; d < 3; ++d) longest = std::max(longest, hi_[d] - lo_[d]);
  for (int d = 0; d < 3; ++d) size[d] = std::max(hi_[d] - lo_[d], 1e-3 * longest) * (1 + 1e-9);
  const double wanted = std::min(64 + 16.0 * double(triangle_.size()), 4e6);
  const double width = std::cbrt(size[0] * size[1] * size[2] / wanted);
  for (int d = 0; d < 3; ++d) {
    bins_[d] = std::min(std::max(int(size[d] / width), 1), 1000);
    bin_lo_[d] = 0.5 * (lo_[d] + hi_[d] - size[d]);
    bin_width_[d] = size[d] / bins_[d];
  }
  start_.assign(std::size_t(bins_[0]) * bins_[1] * bins_[2] + 1, 0);
  for (const Triangle& t : triangle_) for_each_bin(t, [&](std::size_t b) { ++start_[b + 1]; });
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  member_.resize(start_.back());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (std::size_t t = 0; t < triangle_.size(); ++t)
    for_each_bin(triangle_[t], [&](std::size_t b) { member_[next[b]++] = int(t); });
}

int TriangleSet::bin_along(int d, double x) const {
  const double place = (x - bin_lo_[d]) / bin_width_[d];
  return place <= 0 ? 0 : place >= bins_[d] ? bins_[d] - 1 : int(place);
}

template <class F>
void TriangleSet::for_each_bin(const Triangle& t, F&& f) const {
  const Vec3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
  Int3 first, last;
  double half = 0;  // of a bin, across the triangle's plane
  for (int d = 0; d < 3; ++d) {
    const double slack = 1e-6 * bin_width_[d];
    first[d] = bin_along(d, std::min({t[0][d], t[1][d], t[2][d]}) - slack);
    last[d] = bin_along(d, std::max({t[0][d], t[1][d], t[2][d]}) + slack);
    half += 0.5001 * bin_width_[d] * std::abs(n[d]);
  }
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const Vec3 centre{bin_lo_[0] + (i + 0.5) * bin_width_[0], bin_lo_[1] + (j + 0.5) * bin_width_[1],
                          bin_lo_[2] + (k + 0.5) * bin_width_[2]};
        if (std::abs(dot(minus(centre, t[0]), n)) <= half) f(bin(i, j, k));
      }
}

double TriangleSet::first_crossing(const Vec3& x, int d, double length) const {
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  if (x[e] < lo_[e] || x[e] > hi_[e] || x[f] < lo_[f] || x[f] > hi_[f]) return kNone;
  const Point p{x[e], x[f]};
  const double low = std::min(x[d], x[d] + length), high = std::max(x[d], x[d] + length);
  if (high < lo_[d] || low > hi_[d]) return kNone;
  Int3 at;
  at[e] = bin_along(e, x[e]), at[f] = bin_along(f, x[f]);
  const double slack = 1e-6 * bin_width_[d];
  const int first = bin_along(d, low - slack), last = bin_along(d, high + slack);
  double best = kNone;
  for (at[d] = first; at[d] <= last; ++at[d]) {
    const std::size_t b = bin(at[0], at[1], at[2]);
    for (int m = start_[b]; m < start_[b + 1]; ++m) {
      const Triangle& t = triangle_[member_[m]];
      const Point q[3] = {{t[0][e], t[0][f]}, {t[1][e], t[1][f]}, {t[2][e], t[2][f]}};
      const int side = turn_untied(q[0], q[1], p);
      if (side == 0 || turn_untied(q[1], q[2], p) != side || turn_untied(q[2], q[0], p) != side) continue;
      double weight[3], sum = 0, place = 0;
      for (int c = 0; c < 3; ++c) {
        const Point &v = q[(c + 1) % 3], &w = q[(c + 2) % 3];
        weight[c] = std::abs((w[0] - v[0]) * (p[1] - v[1]) - (w[1] - v[1]) * (p[0] - v[0]));
        sum += weight[c];
      }
      // Seen so much from the side that the rounded weights vanish: anywhere in it.
      for (int c = 0; c < 3; ++c) place += (sum > 0 ? weight[c] / sum : 1.0 / 3) * t[c][d];
      const double share = (place - x[d]) / length;
      if (share >= 0 && share <= 1 && share < best) best = share;
    }
  }
  return best;
}

/// Looks into boxes around x that grow until one holds what is nearest.
double TriangleSet::distance(const Vec3& x, double reach, Vec3& nearest) const {
  double outside = 0, widest = 0;
  for (int d = 0; d < 3; ++d) {
    const double out = std::max({lo_[d] - x[d], x[d] - hi_[d], 0.0});
    outside += out * out;
    widest = std::max(widest, bin_width_[d]);
  }
  outside = std::sqrt(outside);
  for (double within = std::min(outside + 0.5 * widest, reach); outside <= reach;
       within = std::min(2 * within, reach)) {
    double square = within * within;
    if (nearest_within(x, within, square, nearest)) return std::sqrt(square);
    if (within >= reach) break;
  }
  return std::numeric_limits<double>::infinity();
}

bool TriangleSet::nearest_within(const Vec3& x, double reach, double& square, Vec3& nearest) const {
  Int3 first, last;
  for (int d = 0; d < 3; ++d) first[d] = bin_along(d, x[d] - reach), last[d] = bin_along(d, x[d] + reach);
  const auto away = [&](int d, int i) {
    const double low = bin_lo_[d] + i * bin_width_[d], out = std::max({low - x[d], x[d] - low - bin_width_[d], 0.0});
    return out * out * (1 - 1e-9);
  };
  bool found = false;
  double least = reach;
  for (int k = first[2]; k <= last[2]; ++k) {
    const double away_k = away(2, k);
    for (int j = first[1]; j <= last[1]; ++j) {
      const double away_j = away_k + away(1, j);
      if (away_j > square) continue;
      for (int i = first[0]; i <= last[0]; ++i) {
        const std::size_t b = bin(i, j, k);
        if (start_[b] == start_[b + 1] || away_j + away(0, i) > square) continue;
        for (int m = start_[b]; m < start_[b + 1]; ++m) {
          const int t = member_[m];
          if (std::abs(dot(minus(x, triangle_[t][0]), normal_[t])) > least) continue;
          const Vec3 p = on_triangle(triangle_[t], x), way = minus(p, x);
          const double far = dot(way, way);
          if (far < square) square = far, least = std::sqrt(far) * (1 + 1e-9), nearest = p, found = true;
        }
      }
    }
  }
  return found;
}

std::vector<Triangle> without_lids(const std::vector<Triangle>& triangles, const FineGrid& grid) {
  constexpr double kIn = 1e-4;  // cells: a surface so near lies in the plane (files hold seven digits)
  std::vector<Triangle> left;
  for (const Triangle& t : triangles) {
    bool lid = false;
    for (int d = 0; d < 3; ++d) {
      const Axis& axis = grid.axis[d];
      if (axis.periodic()) continue;
      const auto in = [&](double plane, double width) {
        return std::abs(t[0][d] - plane) < kIn * width && std::abs(t[1][d] - plane) < kIn * width &&
               std::abs(t[2][d] - plane) < kIn * width;
      };
      lid = lid || in(axis.lo(), axis.width(0)) || in(axis.hi(), axis.width(axis.n() - 1));
    }
    if (!lid) left.push_back(t);
  }
  return left.empty() ? triangles : left;
}

}  // namespace twogrid
