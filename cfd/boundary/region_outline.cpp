#include "cfd/boundary/region_outline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "cfd/grid/grid.h"

namespace twogrid {

namespace {

constexpr double kLooks = 1.6e5, kMoreLooks = 5e5,
                 kSearch = 1.6e7;                   // points: at first, where it ends, where nothing was found
constexpr int kMostAcross = 400, kMostWithin = 64;  // of a tile, and of a part of it
constexpr std::size_t kMostTiles = 4000;

using Rect = std::array<double, 4>;  // lo hi lo hi

/// The parts of a side that boxes cut it into, those that lie in one.
std::vector<Rect> tiles_of(const std::vector<Rect>& boxes) {
  std::array<std::vector<double>, 2> edges;
  Rect hull{1e300, -1e300, 1e300, -1e300};
  for (const Rect& b : boxes)
    for (int q = 0; q < 2; ++q) {
      edges[q].push_back(b[2 * q]), edges[q].push_back(b[2 * q + 1]);
      hull[2 * q] = std::min(hull[2 * q], b[2 * q]), hull[2 * q + 1] = std::max(hull[2 * q + 1], b[2 * q + 1]);
    }
  for (auto& e : edges) {
    std::sort(e.begin(), e.end());
    e.erase(std::unique(e.begin(), e.end()), e.end());
  }
  std::vector<Rect> tiles;
  if (edges[0].size() * edges[1].size() > 100 * kMostTiles) return {hull};
  for (std::size_t j = 0; j + 1 < edges[1].size(); ++j)
    for (std::size_t i = 0; i + 1 < edges[0].size(); ++i) {
      const Rect t{edges[0][i], edges[0][i + 1], edges[1][j], edges[1][j + 1]};
      const double x = 0.5 * (t[0] + t[1]), y = 0.5 * (t[2] + t[3]);
      if (std::any_of(boxes.begin(), boxes.end(),
                      [&](const Rect& b) { return x > b[0] && x < b[1] && y > b[2] && y < b[3]; }))
        tiles.push_back(t);
      if (tiles.size() > kMostTiles) return {hull};
    }
  return tiles;
}

class Looker {
 public:
  Looker(const PatchShape& shape, int side, const std::array<double, 6>& domain)
      : shape_(shape), e_(direction(side) == 0 ? 1 : 0), f_(direction(side) == 2 ? 1 : 2) {
    x_[direction(side)] = domain[side];
    whole_ = {domain[2 * e_], domain[2 * e_ + 1], domain[2 * f_], domain[2 * f_ + 1]};
    found_.extent = {1e300, -1e300, 1e300, -1e300};
  }

  /// n x n points in each tile; false: none lies inside.
  bool look(const std::vector<Rect>& tiles, int n) {
    std::vector<Rect> edges;
    for (const Rect& tile : tiles) look(tile, n, edges);
    const int m = std::clamp(int(std::sqrt(kMoreLooks / std::max(1.0, double(edges.size())))), 1, kMostWithin) |
                  1;  // odd: its middle again
    for (const Rect& part : edges) look_closer(part, m);
    return found_.found;
  }
  const RegionOutline& found() const { return found_; }
  const Rect& whole() const { return whole_; }

 private:
  bool inside(double x, double y) {
    x_[e_] = x, x_[f_] = y;
    return shape_.inside(x_);
  }

  /// Counts parts that lie wholly inside; those at which the shape may end, or that lie at the tile's edge, are collected.
  void look(const Rect& tile, int n, std::vector<Rect>& edges) {
    const double a = (tile[1] - tile[0]) / n, b = (tile[3] - tile[2]) / n;
    std::vector<char> in(std::size_t(n) * n);
    bool any = false;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        any |= in[std::size_t(j) * n + i] = inside(tile[0] + (i + 0.5) * a, tile[2] + (j + 0.5) * b);
    if (!any) return;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        bool all = true, some = false;
        for (int q = std::max(0, j - 1); q <= std::min(n - 1, j + 1); ++q)
          for (int p = std::max(0, i - 1); p <= std::min(n - 1, i + 1); ++p) {
            const bool here = in[std::size_t(q) * n + p];
            all = all && here, some = some || here;
          }
        if (!some) continue;
        if (all && i > 0 && j > 0 && i < n - 1 && j < n - 1) {
          found_.area += a * b;
          found_.found = true;
        } else {
          edges.push_back({tile[0] + i * a, tile[0] + (i + 1) * a, tile[2] + j * b, tile[2] + (j + 1) * b});
        }
      }
  }

  void look_closer(const Rect& part, int m) {
    const double a = (part[1] - part[0]) / m, b = (part[3] - part[2]) / m;
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) {
        const double x = part[0] + (i + 0.5) * a, y = part[2] + (j + 0.5) * b;
        if (!inside(x, y)) continue;
        found_.found = true;
        found_.area += a * b;
        reach(0, x, y, a), reach(1, y, x, b);
      }
  }

  /// From a point inside to where the shape ends, a step away at most.
  void reach(int q, double at, double across, double step) {
    const auto is_in = [&](double z) { return q == 0 ? inside(z, across) : inside(across, z); };
    const auto end = [&](double out) {
      if (is_in(out)) return out;
      double in = at;
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (in + out);
        (is_in(middle) ? in : out) = middle;
      }
      return in;
    };
    double &first = found_.extent[2 * q], &last = found_.extent[2 * q + 1];
    if (const double out = std::max(at - step, whole_[2 * q]); out < first) first = std::min(first, end(out));
    if (const double out = std::min(at + step, whole_[2 * q + 1]); out > last) last = std::max(last, end(out));
  }

  const PatchShape& shape_;
  int e_, f_;
  Vec3 x_{};
  Rect whole_{};
  RegionOutline found_;
};

int across(double points, std::size_t tiles, int most) {
  return std::clamp(int(std::sqrt(points / double(tiles))), 4, most);
}

}  // namespace

RegionOutline measure_region(const PatchShape& shape, int side, const std::array<double, 6>& domain) {
  if (!shape.inside) return {};
  Looker looker(shape, side, domain);
  const Rect& whole = looker.whole();
  const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
  const double slack = 1e-9 * (domain[2 * d + 1] - domain[2 * d]);
  std::vector<Rect> boxes;
  for (const std::array<double, 6>& b : shape.boxes) {
    if (domain[side] < b[2 * d] - slack || domain[side] > b[2 * d + 1] + slack) continue;
    const Rect r{std::max(b[2 * e], whole[0]), std::min(b[2 * e + 1], whole[1]), std::max(b[2 * f], whole[2]),
                 std::min(b[2 * f + 1], whole[3])};
    if (r[0] < r[1] && r[2] < r[3]) boxes.push_back(r);
  }
  if (shape.boxes.empty()) boxes.push_back(whole);
  const std::vector<Rect> tiles = tiles_of(boxes);
  if (tiles.empty()) return {};
  if (!looker.look(tiles, across(kLooks, tiles.size(), kMostAcross)) &&
      !looker.look(tiles, across(kSearch, tiles.size(), 10 * kMostAcross)))
    return {};
  return looker.found();
}

void measure_regions(FluidSettings& fluid, const std::array<double, 6>& domain) {
  for (int side = 0; side < 6; ++side)
    for (BoundaryCondition& c : fluid.side[side])
      if (c.shape.kind == PatchShape::Kind::kRegion && !c.shape.outline)
        c.shape.outline = measure_region(c.shape, side, domain);
}

}  // namespace twogrid
