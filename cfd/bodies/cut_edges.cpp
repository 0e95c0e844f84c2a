#include "cfd/bodies/cut_edges.h"

#include <cmath>

namespace twogrid {

namespace {

constexpr int kBlock = 4;  // vertices a side that are looked at together: far from all surfaces none is met

}  // namespace

CutEdges::CutEdges(const LocalGrid& grid, const Surfaces& surfaces) : grid_(grid), surfaces_(surfaces) {
  const Box& all = grid.vertices;
  on_.reset(all, 0);
  for (int d = 0; d < 3; ++d) {
    Box edges = all;
    if (!edges.empty()) --edges.hi[d];
    place_[d].reset(edges, -1);
  }
  for (int k = all.lo[2]; k < all.hi[2]; k += kBlock)
    for (int j = all.lo[1]; j < all.hi[1]; j += kBlock)
      for (int i = all.lo[0]; i < all.hi[0]; i += kBlock)
        find(intersect({{i, j, k}, {i + kBlock, j + kBlock, k + kBlock}}, all));
}

/// Vertices on surfaces, and crossings of the edges that go up from the block's vertices.
void CutEdges::find(const Box& block) {
  const LocalGrid& g = grid_;
  Vec3 centre;
  double square = 0, h = 1e300;
  bool seam = false;  // reaches beyond a periodic side
  for (int d = 0; d < 3; ++d) {
    const int last = std::min(block.hi[d], g.cells.hi[d]);
    double length = 0;
    for (int i = block.lo[d]; i < last; ++i) length += g.width(d, i);
    seam = seam || (g.grid.axis[d].periodic() && (block.lo[d] < 0 || last > g.grid.axis[d].n()));
    centre[d] = g.node(d, block.lo[d]) + 0.5 * length;
    square += 0.25 * length * length;
    for (int i = block.lo[d]; i <= std::min(last, g.cells.hi[d] - 1); ++i) h = std::min(h, g.width(d, i));
  }
  const double reach = 1.01 * std::sqrt(square) + h;
  if (!seam && surfaces_.nearest(centre, reach).body < 0) return;
  for_each(block, [&](int i, int j, int k) {
    const Int3 v{i, j, k};
    Vec3 x;
    double least = 1e300;
    for (int d = 0; d < 3; ++d) {
      x[d] = g.inner_node(d, v[d]);
      // The narrowest of the cells around, periodic images and mirror images included.
      const int w = g.wrap(d, v[d]);
      least = std::min({least, g.grid.axis[d].width(w), g.grid.axis[d].width(w - 1)});
    }
    on_(i, j, k) = surfaces_.nearest(x, LocalGrid::kOn * least).body >= 0;
    for (int d = 0; d < 3; ++d)
      if (v[d] + 1 < g.vertices.hi[d]) cross(d, v);
  });
}

/// Looks along the grid's own line first; in a side's plane, where a surface that ends there may be missed by a rounding,
/// then along one a little inwards.
void CutEdges::cross(int d, const Int3& low) {
  const LocalGrid& g = grid_;
  Vec3 line, inner;
  for (int e = 0; e < 3; ++e) {
    line[e] = g.node(e, low[e]), inner[e] = g.inner_node(e, low[e]);
    if (e != d && g.grid.axis[e].periodic() && g.wrap(e, low[e]) == 0)
      inner[e] += LocalGrid::kInwards * g.width(e, low[e]);
  }
  const double width = g.width(d, low[d]), begin = inner[d] - line[d];
  const bool last = !g.grid.axis[d].periodic() && low[d] + 1 == g.grid.axis[d].n();
  const double length = width - begin - (last ? LocalGrid::kInwards * width : 0);
  line[d] = inner[d];
  Vec3 end = line;
  end[d] += length;
  Surfaces::Hit up = surfaces_.first_crossing(line, d, length), down = surfaces_.first_crossing(end, d, -length);
  if (up.body < 0 && down.body < 0 && line != inner) {
    end = inner;
    end[d] += length;
    up = surfaces_.first_crossing(inner, d, length), down = surfaces_.first_crossing(end, d, -length);
  }
  if (up.body < 0 && down.body < 0) return;
  if (up.body < 0) up = {1 - down.share, down.body};
  if (down.body < 0) down = {1 - up.share, up.body};
  place_[d](low[0], low[1], low[2]) = int(crossing_.size());
  crossing_.push_back(
      {(begin + up.share * length) / width, 1 - (begin + (1 - down.share) * length) / width, up.body, down.body});
}

bool CutEdges::touches(const Int3& c) const {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    for (int q = 0; q < 4; ++q) {
      Int3 v = c;
      v[e] += q & 1, v[f] += q >> 1;
      if (at(d, v[0], v[1], v[2])) return true;
      if (d == 0 && (on_surface(v[0], v[1], v[2]) || on_surface(v[0] + 1, v[1], v[2]))) return true;
    }
  }
  return false;
}

unsigned CutEdges::joined_corners(int d, const Int3& face) const {
  const LocalGrid& g = grid_;
  const Vec3 centre = g.face_centre(d, face);
  const int across[2] = {(d + 1) % 3, (d + 2) % 3};
  constexpr double kFurther = 1 + LocalGrid::kOn;
  unsigned joined = 0;
  for (int way = 0; way < 2; ++way) {
    // From a corner along a, which is an edge of the face, to the edge's middle; then along b to the centre.
    const int a = across[way], b = across[1 - way];
    for (int side = 0; side < 2; ++side) {
      Int3 edge = face;
      edge[b] += side;
      const Crossing* c = at(a, edge[0], edge[1], edge[2]);
      const bool from_low = !c || c->low > 0.5 * kFurther, from_high = !c || c->high > 0.5 * kFurther;
      if (!from_low && !from_high) continue;
      const double width = g.width(b, face[b]), inwards = g.inner_node(b, edge[b]) - g.node(b, edge[b]);
      Vec3 middle = centre;
      middle[b] = g.node(b, face[b]) + side * width + inwards;
      if (surfaces_.first_crossing(middle, b, kFurther * (centre[b] - middle[b])).body >= 0) continue;
      for (int end = 0; end < 2; ++end)
        if (end ? from_high : from_low) joined |= 1u << (way == 0 ? end + 2 * side : side + 2 * end);
    }
  }
  return joined;
}

}  // namespace twogrid
