// What WallLinks lists of walls that blow (fluid/blowing.h): where they do, their normals, and what their velocity adds to
// pieces, slivers and faces.
#include <algorithm>
#include <cmath>

#include "cfd/bodies/wall_links.h"

namespace twogrid {

/// Of the cells beside a face and those of this rank.
double WallLinks::least_width(int c, const Int3& face) const {
  double least = 1e300;
  const auto look = [&](int d, int cell) {
    if (cell >= grid_.cells.lo[d] && cell < grid_.cells.hi[d]) least = std::min(least, grid_.width(d, cell));
  };
  for (int d = 0; d < 3; ++d) {
    look(d, face[d]);
    if (d == c || !grid_.inside(d, face[d])) look(d, face[d] - 1);
  }
  return least;
}

bool WallLinks::blows(int body, const Vec3& point, const Vec3& shift) const {
  if (body < 0 || !surfaces_.bodies()[body].blow.on) return false;
  const auto& where = surfaces_.bodies()[body].blow.where;
  return !where || where({point[0] - shift[0], point[1] - shift[1], point[2] - shift[2]});
}

/// Which share of a body's surface in a cell blows: of points of it, nearest to points of the cell.
double WallLinks::blown_share(const Int3& cell, int body) const {
  if (!surfaces_.bodies()[body].blow.on) return 0;
  if (!surfaces_.bodies()[body].blow.where) return 1;
  constexpr int kPoints = 6;
  int all = 0, blown = 0;
  double reach = 0;
  for (int d = 0; d < 3; ++d) reach += grid_.width(d, cell[d]);
  for (int q = 0; q < kPoints * kPoints * kPoints; ++q) {
    const Int3 at{q % kPoints, q / kPoints % kPoints, q / (kPoints * kPoints)};
    Vec3 x;
    for (int d = 0; d < 3; ++d) x[d] = grid_.node(d, cell[d]) + (at[d] + 0.5) / kPoints * grid_.width(d, cell[d]);
    const Surfaces::Foot foot = surfaces_.nearest(x, reach);
    bool inside = foot.body == body;
    for (int d = 0; d < 3; ++d) {
      const double slack = 1e-3 * grid_.width(d, cell[d]), low = grid_.node(d, cell[d]) - slack;
      inside = inside && foot.point[d] >= low && foot.point[d] <= low + grid_.width(d, cell[d]) + 2 * slack;
    }
    if (!inside) continue;
    ++all, blown += blows(body, foot.point, foot.shift);
  }
  return all > 0 ? double(blown) / all : 0;
}

/// Of a body's surface at one of its points, into the fluid; about: nearly this, of length 1.
Vec3 WallLinks::normal_at(const Vec3& point, int body, const Vec3& about, double width) const {
  Vec3 before;
  for (int d = 0; d < 3; ++d) before[d] = point[d] + 0.4 * width * about[d];
  const Surfaces::Foot foot = surfaces_.nearest(before, width);
  if (foot.body != body || foot.distance < 0.01 * width) return about;
  Vec3 normal;
  for (int d = 0; d < 3; ++d) normal[d] = (before[d] - foot.point[d]) / foot.distance;
  return normal;
}

WallLinks::Blowing WallLinks::blowing(int c, const Int3& face) const {
  Blowing none;
  const Vec3 x = place(c, face);
  const double width = least_width(c, face);
  const Surfaces::Foot foot = surfaces_.nearest(x, 6 * width);
  if (!blows(foot.body, foot.point, foot.shift)) return none;
  Vec3 way;
  const bool open = alpha_[c](face[0], face[1], face[2]) > 0;
  for (int d = 0; d < 3; ++d) way[d] = open ? x[d] - foot.point[d] : foot.point[d] - x[d];
  double size = foot.distance;
  // On the surface: as the walls of the cells around say.
  if (!(size > 0.02 * width)) {
    Box around;
    way = {0, 0, 0};
    for (int wider = 0; wider < 2 && way == Vec3{0, 0, 0}; ++wider) {
      for (int d = 0; d < 3; ++d)
        around.lo[d] = face[d] - (d == c ? 1 : wider), around.hi[d] = face[d] + (d == c ? 1 : 1 + wider);
      for_each(intersect(around, cut_.box()), [&](int i, int j, int k) {
        const Vec3 a = wall_area({i, j, k});
        for (int d = 0; d < 3; ++d) way[d] += a[d];
      });
    }
    size = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    if (!(size > 0)) return none;
  }
  for (double& w : way) w /= size;
  return {foot.body, normal_at(foot.point, foot.body, way, width)};
}

/// The normal of the wall nearest to the centre of a face in the fluid, if the same body blows there, else 0. beside: of
/// its open part.
Vec3 WallLinks::blown_at_centre(int c, const Int3& face, const Blowing& beside, double centre) const {
  if (centre == 1) return beside.normal;
  const Vec3 x = grid_.face_centre(c, face);
  const double width = least_width(c, face);
  const Surfaces::Foot foot = surfaces_.nearest(x, 6 * width);
  if (foot.body != beside.body || !blows(foot.body, foot.point, foot.shift)) return {0, 0, 0};
  return normal_at(foot.point, foot.body, beside.normal, width);
}

/// What a piece of a face's friction has of the walls' blowing: the piece is `centre` times as strong as one on the
/// velocity at the face's centre would be, and so is what it has of the change of the wall's velocity along the wall.
void WallLinks::blow_piece(const WallPiece& piece, const Blowing& beside, const Vec3& shift, const Vec3& towards,
                           double centre, OpenSpace& space) const {
  const int c = piece.component, place = int(space.pieces.size()) - 1;
  const double width = least_width(c, piece.face);
  double own = 0, its = 0;
  if (beside.body >= 0 && centre < 1)
    own = beside.normal[c] - blown_at_centre(c, piece.face, beside, centre)[c] / centre;
  if (blows(piece.body, piece.point, shift)) {
    const Vec3& about = piece.body == beside.body ? beside.normal : towards;
    its = normal_at(piece.point, piece.body, about, width)[c] / centre;
  }
  if (piece.body == beside.body) own += its, its = 0;
  if (own != 0) space.blown_pieces.push_back({beside.body, place, own, 0});
  if (its != 0) space.blown_pieces.push_back({piece.body, place, its, 0});
}

void WallLinks::blow_sliver(const Sliver& s, OpenSpace& space) const {
  const int c = s.component;
  const Blowing own = blowing(c, s.face);
  if (own.body < 0) return;
  double drift = own.normal[c];
  for (int q = 0; q < 6; ++q) {
    if (!(s.share[q] > 0)) continue;
    Int3 next = s.face;
    next[q / 2] += q % 2 ? 1 : -1;
    const Blowing there = blowing(c, next);
    if (there.body == own.body) drift -= s.share[q] * there.normal[c];
  }
  space.blown_slivers.push_back({own.body, int(space.slivers.size()) - 1, own.normal[c], drift});
}

void WallLinks::blow_face(int c, const Int3& face, OpenSpace& space) const {
  if (!near_cut(c, face)) return;
  const Blowing own = blowing(c, face);
  if (own.body < 0) return;
  const double centre = space.centre[c](face[0], face[1], face[2]);
  const bool slip = surfaces_.bodies()[own.body].slip;
  const double drift = slip ? 0 : blown_at_centre(c, face, own, centre)[c] - centre * own.normal[c];
  space.blown_faces.push_back({own.body, c, face, own.normal[c], drift});
}

}  // namespace twogrid
