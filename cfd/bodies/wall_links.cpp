#include "cfd/bodies/wall_links.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

WallLinks::WallLinks(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges, const CutFaces& faces,
                     const FaceField<FineGrid>& alpha, const CellField<FineGrid>& theta,
                     const Array3<char>& beside_sheets)
    : grid_(grid), surfaces_(surfaces), faces_(faces), alpha_(alpha), theta_(theta), beside_sheets_(beside_sheets) {
  for (const Body& body : surfaces.bodies())
    moving_ = moving_ || (body.motion.any() && !body.slip), blowing_ = blowing_ || body.blow.on;
  cut_.reset(grid.cells, 0);
  for_each(grid.cells, [&](int i, int j, int k) {
    cut_(i, j, k) = edges.touches({i, j, k}) || beside_sheets(i, j, k);
  });
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

/// Area of the walls in a cell; walls that lie in its faces count each, steps of a sheet as the slope that they stand for.
double WallLinks::wall_size(const Int3& cell) const {
  const Vec3 a = wall_area(cell);
  if (a[0] == 0 && a[1] == 0 && a[2] == 0) return 0;
  if (faces_.aligned(cell) && !beside_sheets_(cell[0], cell[1], cell[2]))
    return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]);
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

/// Between the centres of a face and of the next one of its component, m; beyond a side of the domain that of its image.
double WallLinks::way(int c, const Int3& face, int d, bool up) const {
  const int next = up ? face[d] + 1 : face[d] - 1;
  if (d == c) return grid_.width(d, up ? face[d] : next);
  return 0.5 * (grid_.width(d, face[d]) + grid_.width(d, grid_.inside(d, next) ? next : face[d]));
}

void WallLinks::add(std::vector<WallPiece>& pieces, int body, int c, const Int3& face, double conductance,
                    const Vec3& point, const Vec3& shift) const {
  if (body < 0 || surfaces_.bodies()[body].slip || !(conductance > 0)) return;
  pieces.push_back({body, c, face, conductance, point});
  if (!moving_) return;
  const Rigid own = rigid(c, face), its{body, shift};
  double& u = pieces.back().velocity = velocity(own, place(c, face))[c];
  if (own.body != its.body || own.shift != its.shift) u += velocity(its, point)[c] - velocity(own, point)[c];
}

/// One link of a fluid face: the same way is looked along from the low end to the high one, whichever face asks.
void WallLinks::link(int c, const Int3& face, int d, bool up, double centre, unsigned char& bits,
                     OpenSpace& space) const {
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
  const double whole = way(c, face, d, up), length = at_side ? 0.5 * whole : whole;  // m; whole: as the grid has it
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
  const double reach = std::max(share * length, kLeast * centre * whole);
  Vec3 point = here;
  point[d] += up ? share * length : -share * length;
  const Surfaces::Hit& hit = from_here.body >= 0 ? from_here : from_there;
  Rigid wall{hit.body, hit.shift};
  if (wall.body < 0) {
    const Surfaces::Foot foot = surfaces_.nearest(point, 2 * whole);
    wall = {foot.body, foot.shift};
  }
  const std::size_t before = space.pieces.size();
  if (reach > 0) add(space.pieces, wall.body, c, face, centre * aperture(c, face, d, up) / reach, point, wall.shift);
  if (!blowing_ || space.pieces.size() == before) return;
  Vec3 towards{0, 0, 0};
  towards[d] = up ? -1 : 1;
  blow_piece(space.pieces.back(), blowing(c, face), wall.shift, towards, centre, space);
}

Vec3 WallLinks::place(int c, const Int3& face) const {
  Vec3 x = grid_.face_centre(c, face);
  const auto open = faces_.open(c, face);
  for (int m = 0; m < 2 && open.share < 1; ++m) {
    const int e = (c + 1 + m) % 3;
    x[e] = grid_.node(e, face[e]) + open.centroid[m] * grid_.width(e, face[e]);
  }
  return x;
}

WallLinks::Rigid WallLinks::rigid(int c, const Int3& face) const {
  const Surfaces::Foot wall = wall_near(c, face);
  return {wall.body, wall.shift};
}

Vec3 WallLinks::velocity(const Rigid& of, const Vec3& x) const {
  if (of.body < 0 || surfaces_.bodies()[of.body].slip) return {0, 0, 0};
  return surfaces_.bodies()[of.body].motion.at({x[0] - of.shift[0], x[1] - of.shift[1], x[2] - of.shift[2]});
}

/// Whether a face has a cut cell beside it or beside that.
bool WallLinks::near_cut(int c, const Int3& face) const {
  Box around;
  for (int d = 0; d < 3; ++d) around.lo[d] = face[d] - (d == c ? 2 : 1), around.hi[d] = face[d] + 2;
  bool near = false;
  for_each(intersect(around, cut_.box()), [&](int i, int j, int k) { near = near || cut_(i, j, k); });
  return near;
}

/// What a face near walls sees of the nearest wall's motion.
void WallLinks::beside_moving(int c, const Int3& face, OpenSpace& space) const {
  if (!near_cut(c, face)) return;
  const Rigid wall = rigid(c, face);
  if (wall.body < 0 || surfaces_.bodies()[wall.body].slip) return;
  const SurfaceMotion& motion = surfaces_.bodies()[wall.body].motion;
  const double u = velocity(wall, place(c, face))[c];
  space.wall_velocity[c](face[0], face[1], face[2]) = u;
  space.drift[c](face[0], face[1], face[2]) =
      velocity(wall, grid_.face_centre(c, face))[c] - space.centre[c](face[0], face[1], face[2]) * u;
  if (motion.turning == Vec3{0, 0, 0}) return;
  const int e = (c + 1) % 3, f = (c + 2) % 3;
  OpenSpace::Beside beside{c, face, {0, 0, 0}};
  beside.slope[f] = motion.turning[e], beside.slope[e] = -motion.turning[f];
  space.beside.push_back(beside);
}

Surfaces::Foot WallLinks::wall_near(int c, const Int3& face) const {
  const LocalGrid& g = grid_;
  double reach = 0, least = 1e300;
  for (int below = 0; below < 2; ++below) {
    Int3 cell = face;
    cell[c] -= below;
    if (!g.inside(c, cell[c])) continue;
    cell[c] = std::max(cell[c], g.cells.lo[c]);  // one that the rank doesn't have: as wide as the next
    for (int d = 0; d < 3; ++d) reach += g.width(d, cell[d]), least = std::min(least, g.width(d, cell[d]));
  }
  Surfaces::Foot foot = surfaces_.nearest(place(c, face), reach);
  foot.distance = std::max(foot.distance, kLeast * least);
  return foot;
}

/// Velocity at the face's centre over that of its open part.
double WallLinks::centre(int c, const Int3& face) const {
  if (!is_cut(c, face) || !(faces_.open(c, face).share < 1)) return 1;
  const Surfaces::Foot wall = wall_near(c, face);
  if (wall.body < 0 || surfaces_.bodies()[wall.body].slip) return 1;
  return std::min(surfaces_.nearest(grid_.face_centre(c, face), wall.distance).distance / wall.distance, 1.0);
}

/// The face's open volume over that for which its links and friction give the second derivative across the wall.
/// bits: the links it has.
double WallLinks::viscous(int c, const Int3& face, unsigned char bits) const {
  const LocalGrid& g = grid_;
  if (bits == OpenSpace::kAllLinks && !is_cut(c, face)) return 1;
  const Surfaces::Foot wall = wall_near(c, face);
  if (wall.body < 0 || surfaces_.bodies()[wall.body].slip) return 1;
  double volume = 0, area = 0;
  Vec3 normal{0, 0, 0};
  for (int below = 0; below < 2; ++below) {
    Int3 cell = face;
    cell[c] -= below;
    if (!g.inside(c, cell[c])) continue;
    volume += 0.5 * theta_(cell[0], cell[1], cell[2]) * g.volume(cell);
    area += 0.5 * wall_size(cell);
    const Vec3 a = wall_area(cell);
    for (int d = 0; d < 3; ++d) normal[d] += a[d];
  }
  const Vec3 x = g.face_centre(c, face);
  const Surfaces::Foot foot = surfaces_.nearest(x, 2 * wall.distance);
  if (foot.body < 0) return 1;
  if (!(area > 0))
    for (int d = 0; d < 3; ++d) normal[d] = x[d] - foot.point[d];
  const double size = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (!(size > 0)) return 1;
  double bent = area * foot.distance;
  for (int d = 0; d < 3; ++d)
    for (bool up : {false, true}) {
      if (d == c && !g.inside(d, up ? face[d] : face[d] - 1)) continue;
      const double slope = std::abs(normal[d]) / size, a = aperture(c, face, d, up);
      if (bits >> (2 * d + int(up)) & 1)
        bent += a * way(c, face, d, up) * slope * slope;
      else
        bent += a * foot.distance * slope;
    }
  return std::min(std::max(2 * volume / bent, kLeastViscous), kMostViscous);
}

/// What it would have in shear along the wall, of each fluid face beside it: by their distances from the wall.
Sliver WallLinks::sliver(int c, const Int3& face) const {
  Sliver s{c, face, {0, 0, 0, 0, 0, 0}};
  const Surfaces::Foot wall = wall_near(c, face);
  if (wall.body < 0) return s;
  const bool slip = surfaces_.bodies()[wall.body].slip;
  double sum = 0;
  for (int d = 0; d < 3; ++d)
    for (bool up : {false, true}) {
      Int3 next = face;
      next[d] += up ? 1 : -1;
      const bool there = d == c ? grid_.inside(d, up ? face[d] : next[d]) : grid_.inside(d, next[d]);
      if (!there || node_[c](next[0], next[1], next[2]) != Node::kFluid) continue;
      const Surfaces::Foot far = wall_near(c, next);
      if (far.body < 0) continue;
      const double weight = aperture(c, face, d, up) * far.distance;
      sum += weight;
      s.share[2 * d + int(up)] = weight * (slip ? 1.0 : std::min(wall.distance / far.distance, 1.0));
    }
  for (double& w : s.share) w = sum > 0 ? w / sum : 0;
  if (!moving_) return s;
  const Rigid own{wall.body, wall.shift};
  const Vec3 here = place(c, face);
  s.drift = s.velocity = velocity(own, here)[c];
  for (int q = 0; q < 6; ++q) {
    if (!(s.share[q] > 0)) continue;
    Int3 next = face;
    next[q / 2] += q % 2 ? 1 : -1;
    Vec3 there = place(c, next);
    for (int d = 0; d < 3; ++d)
      if (const Axis& axis = grid_.grid.axis[d]; axis.periodic())
        there[d] -= axis.length() * std::round((there[d] - here[d]) / axis.length());
    s.drift -= s.share[q] * velocity(own, there)[c];
  }
  return s;
}

/// The walls in the two halves of the face's momentum volume.
void WallLinks::own_wall(int c, const Int3& face, OpenSpace& space) const {
  double area = 0;
  for (int below = 0; below < 2; ++below) {
    Int3 cell = face;
    cell[c] -= below;
    if (grid_.inside(c, cell[c])) area += 0.5 * wall_size(cell);
  }
  if (!(area > 0)) return;
  const Surfaces::Foot wall = wall_near(c, face);
  const std::size_t before = space.pieces.size();
  add(space.pieces, wall.body, c, face, area / wall.distance, wall.point, wall.shift);
  if (!blowing_ || space.pieces.size() == before) return;
  const Blowing own = blowing(c, face);
  if (own.body >= 0 && own.normal[c] != 0)
    space.blown_pieces.push_back({own.body, int(space.pieces.size()) - 1, own.normal[c], 0});
}

void WallLinks::fill(OpenSpace& space) const {
  const LocalGrid& g = grid_;
  for (int c = 0; c < 3; ++c) {
    space.links[c].reset(g.own_faces[c], OpenSpace::kAllLinks);
    space.centre[c].reset(g.own_faces[c], 1.0), space.viscous[c].reset(g.own_faces[c], 1.0);
    if (moving_) space.wall_velocity[c].reset(g.own_faces[c]), space.drift[c].reset(g.own_faces[c]);
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
        space.slivers.push_back(sliver(c, face));
        if (blowing_) blow_sliver(space.slivers.back(), space);
        own_wall(c, face, space);
      } else {
        const double at_centre = space.centre[c](i, j, k) = centre(c, face);
        const std::size_t first = space.pieces.size();
        for (int d = 0; d < 3; ++d)
          for (bool up : {false, true}) link(c, face, d, up, at_centre, bits, space);
        own_wall(c, face, space);
        const double factor = space.viscous[c](i, j, k) = viscous(c, face, bits);
        for (std::size_t q = first; q < space.pieces.size(); ++q) space.pieces[q].conductance *= factor;
      }
    });
    if (moving_) for_each(g.own_faces[c], [&](int i, int j, int k) { beside_moving(c, {i, j, k}, space); });
    if (blowing_) for_each(g.own_faces[c], [&](int i, int j, int k) { blow_face(c, {i, j, k}, space); });
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
    const double blown = blowing_ ? blown_share(cell, foot.body) : 0;
    if (!(blown > 0)) return;
    const Vec3 along = surfaces_.bodies()[foot.body].motion.at(
        {foot.point[0] - foot.shift[0], foot.point[1] - foot.shift[1], foot.point[2] - foot.shift[2]});
    Vec3 area = wall_area(cell);
    for (double& a : area) a *= blown;
    space.blown_cells.push_back({foot.body, cell, blown * wall_size(cell), area, along});
  });
}

}  // namespace twogrid
