#include "cfd/bodies/wall_links.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

WallLinks::WallLinks(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges, const CutFaces& faces,
                     const FaceField<FineGrid>& alpha, const CellField<FineGrid>& theta)
    : grid_(grid), surfaces_(surfaces), faces_(faces), alpha_(alpha), theta_(theta) {
  cut_.reset(grid.cells, 0);
  for_each(grid.cells, [&](int i, int j, int k) { cut_(i, j, k) = edges.touches({i, j, k}); });
  for (int d = 0; d < 3; ++d) {
    node_[d].reset(grid.faces[d], Node::kClosed);
    for_each(grid.faces[d], [&](int i, int j, int k) {
      if (!(alpha[d](i, j, k) > 0)) return;
      const bool fluid = !is_cut(d, {i, j, k}) || faces.fluid_centre(d, {i, j, k});
      node_[d](i, j, k) = fluid ? Node::kFluid : Node::kSliver;
    });
  }
}

bool WallLinks::is_cut(int d, Int3 face) const {
  bool cut = false;
  for (int below = 0; below < 2; ++below, --face[d])
    cut = cut || (grid_.cells.contains(face[0], face[1], face[2]) && cut_(face[0], face[1], face[2]));
  return cut;
}

Vec3 WallLinks::wall_area(const Int3& cell) const {
  Vec3 sum{0, 0, 0};
  if (!grid_.cells.contains(cell[0], cell[1], cell[2])) return sum;
  for (int d = 0; d < 3; ++d) {
    Int3 above = cell;
    ++above[d];
    sum[d] = (alpha_[d](above[0], above[1], above[2]) - alpha_[d](cell[0], cell[1], cell[2])) * grid_.area(d, cell);
  }
  return sum;
}

/// Area of the walls in a cell; walls that lie in its faces count each.
double WallLinks::wall_size(const Int3& cell) const {
  const Vec3 a = wall_area(cell);
  if (a[0] == 0 && a[1] == 0 && a[2] == 0) return 0;
  if (faces_.aligned(cell)) return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]);
  return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/// Open area that a link up or down along d goes through, m2: along the face's own component c the mean of the two
/// faces; else the halves of the two cells' faces across it.
double WallLinks::aperture(int c, const Int3& face, int d, bool up) const {
  Int3 other = face;
  if (d == c) {
    other[d] += up ? 1 : -1;
    const bool beyond = !grid_.inside(d, up ? face[d] : face[d] - 1);
    const double a = alpha_[c](face[0], face[1], face[2]);
    return (beyond ? a : 0.5 * (a + alpha_[c](other[0], other[1], other[2]))) * grid_.area(c, face);
  }
  double sum = 0;
  for (int below = 0; below < 2; ++below) {
    Int3 cell = face;
    cell[c] -= below;
    if (!grid_.inside(c, cell[c])) continue;
    other = cell;
    other[d] += up;
    sum += 0.5 * alpha_[d](other[0], other[1], other[2]) * grid_.area(d, cell);
  }
  return sum;
}

void WallLinks::add(std::vector<WallPiece>& pieces, int body, int c, const Int3& face, double conductance,
                    const Vec3& point) const {
  if (body < 0 || surfaces_.bodies()[body].slip || !(conductance > 0)) return;
  pieces.push_back({body, c, face, conductance, point});
}

/// One link of a fluid face: the same way is looked along from the low end to the high one, whichever face asks.
void WallLinks::link(int c, const Int3& face, int d, bool up, unsigned char& bits,
                     std::vector<WallPiece>& pieces) const {
  const LocalGrid& g = grid_;
  const unsigned char bit = static_cast<unsigned char>(1u << (2 * d + int(up)));
  Int3 low = face;
  if (!up) --low[d];
  Int3 high = low;
  ++high[d];
  if (d == c ? !g.inside(d, low[d]) : !g.inside(d, low[d]) && !g.inside(d, high[d])) return;
  const bool at_side = d != c && (!g.inside(d, low[d]) || !g.inside(d, high[d]));
  if (d != c && !g.solved[d] && at_side) return;
  // The way between the two centres, or to the side of the domain.
  const Vec3 here = g.face_centre(c, face);
  double length, whole;  // m; whole: of the link as the grid has it
  if (d == c) {
    length = whole = g.width(d, low[d]);
  } else if (at_side) {
    whole = g.width(d, face[d]), length = 0.5 * whole;
  } else {
    length = whole = 0.5 * (g.width(d, low[d]) + g.width(d, high[d]));
  }
  const Node next =
      at_side ? Node::kFluid : node_[c](up ? high[0] : low[0], up ? high[1] : low[1], up ? high[2] : low[2]);
  const bool near = is_cut(c, low) || (!at_side && is_cut(c, high)) || (at_side && is_cut(c, face));
  Surfaces::Hit from_here, from_there;
  if (near) {
    from_here = surfaces_.first_crossing(here, d, up ? length : -length);
    if (!at_side) {
      // From the other face's own place, so that both have the same bits.
      const Int3 other = up ? high : low;
      from_there = surfaces_.first_crossing(g.face_centre(c, other), d, up ? -length : length);
    }
  }
  if (next == Node::kFluid && from_here.body < 0 && from_there.body < 0) return;
  bits &= static_cast<unsigned char>(~bit);
  double share = 1;
  if (from_here.body >= 0)
    share = from_here.share;
  else if (from_there.body >= 0)
    share = 1 - from_there.share;
  const double way = std::max(share * length, kLeast * whole);
  Vec3 point = here;
  point[d] += up ? share * length : -share * length;
  int body = from_here.body >= 0 ? from_here.body : from_there.body;
  if (body < 0) body = surfaces_.nearest(point, 2 * whole).body;
  add(pieces, body, c, face, aperture(c, face, d, up) / way, point);
}

/// The walls in the two halves of the face's momentum volume.
void WallLinks::own_wall(int c, const Int3& face, Node node, std::vector<WallPiece>& pieces) const {
  const LocalGrid& g = grid_;
  double area = 0, reach = 0, least = 1e300;
  for (int below = 0; below < 2; ++below) {
    Int3 cell = face;
    cell[c] -= below;
    if (!g.inside(c, cell[c])) continue;
    area += 0.5 * wall_size(cell);
    for (int d = 0; d < 3; ++d) reach += g.width(d, cell[d]), least = std::min(least, g.width(d, cell[d]));
  }
  if (!(area > 0)) return;
  Vec3 x = g.face_centre(c, face);
  if (node == Node::kSliver) {
    const auto open = faces_.open(c, face);
    for (int m = 0; m < 2; ++m) {
      const int e = (c + 1 + m) % 3;
      x[e] = g.node(e, face[e]) + open.centroid[m] * g.width(e, face[e]);
    }
  }
  const Surfaces::Foot foot = surfaces_.nearest(x, reach);
  add(pieces, foot.body, c, face, area / std::max(foot.distance, kLeast * least), foot.point);
}

void WallLinks::fill(OpenSpace& space) const {
  const LocalGrid& g = grid_;
  for (int c = 0; c < 3; ++c) {
    space.links[c].reset(g.own_faces[c], OpenSpace::kAllLinks);
    for_each(g.own_faces[c], [&](int i, int j, int k) {
      const Int3 face{i, j, k};
      unsigned char& bits = space.links[c](i, j, k);
      const Node node = node_[c](i, j, k);
      if (node == Node::kClosed) {
        bits = 0;
        return;
      }
      if (node == Node::kSliver) {
        bits = OpenSpace::kSliver;
      } else {
        for (int d = 0; d < 3; ++d)
          for (bool up : {false, true}) link(c, face, d, up, bits, space.pieces);
      }
      own_wall(c, face, node, space.pieces);
    });
  }
  for_each(g.own, [&](int i, int j, int k) {
    const Int3 cell{i, j, k};
    if (!(theta_(i, j, k) > 0) || !(wall_size(cell) > 0)) return;
    Vec3 x;
    double reach = 0;
    for (int d = 0; d < 3; ++d) x[d] = g.centre(d, cell[d]), reach += g.width(d, cell[d]);
    const Surfaces::Foot foot = surfaces_.nearest(x, reach);
    if (foot.body < 0) return;
    space.surface.push_back({foot.body, cell, wall_area(cell), foot.point});
  });
}

}  // namespace twogrid
