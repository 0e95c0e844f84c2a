#include "cfd/bodies/opening.h"

#include <algorithm>

namespace twogrid {

namespace {

constexpr double kNoWall = 1e30;
constexpr double kTouching = 1e-3;  // cells: walls that touch, as a cylinder does a side; no opening

class Lines {
 public:
  Lines(const LocalGrid& g, const CutEdges& edges, const FluidVertices& vertices, int d)
      : g_(g), edges_(edges), vertices_(vertices), d_(d) {}

  bool fluid(const Int3& v) const { return vertices_(v[0], v[1], v[2]) == VertexKind::kFluid; }
  /// Way from a fluid vertex along the edge above or below it to a wall (m); kNoWall without one.
  double to_wall(const Int3& v, bool up) const {
    Int3 low = v;
    if (!up) --low[d_];
    Int3 next = v;
    next[d_] += up ? 1 : -1;
    const double width = g_.width(d_, low[d_]);
    if (const Crossing* c = edges_.at(d_, low[0], low[1], low[2])) return width * (up ? c->low : c->high);
    return fluid(next) ? kNoWall : width;
  }
  /// Whether a vertex on a side of the domain is at a wall, as one of the side's faces at it says.
  bool at_side_wall(int side, const Int3& v) const {
    Int3 face = v;
    for (int e = 0; e < 3; ++e)
      if (e != d_ && !g_.grid.axis[e].periodic()) face[e] = std::min(face[e], g_.grid.axis[e].n() - 1);
    return !g_.passes(side, face);
  }

 private:
  const LocalGrid& g_;
  const CutEdges& edges_;
  const FluidVertices& vertices_;
  int d_;
};

}  // namespace

double narrowest_opening(const LocalGrid& g, const Surfaces& surfaces, const CutEdges& edges,
                         const FluidVertices& vertices) {
  double narrowest = kNoWall;
  for (int d = 0; d < 3; ++d) {
    if (g.grid.axis[d].n() < 2) continue;
    const Lines lines(g, edges, vertices, d);
    const int n = g.grid.axis[d].n();
    const bool periodic = g.grid.axis[d].periodic();
    // Way down to the last wall (m), carried up over the ranks until nothing changes.
    Array3<double> since(g.vertices, kNoWall);
    for (int changed = 1; changed > 0;) {
      changed = 0;
      for_each(g.own_vertices, [&](int i, int j, int k) {
        const Int3 v{i, j, k};
        if (!lines.fluid(v)) return;
        double way = kNoWall;
        if (!periodic && v[d] == 0) {
          if (lines.at_side_wall(2 * d, v)) way = 0;
        } else {
          way = lines.to_wall(v, false);
          Int3 below = v;
          --below[d];
          if (way == kNoWall && since(below[0], below[1], below[2]) < kNoWall)
            way = since(below[0], below[1], below[2]) + g.width(d, below[d]);
          if (way > g.grid.axis[d].length()) way = kNoWall;
        }
        if (way != since(i, j, k)) since(i, j, k) = way, changed = 1;
      });
      g.vertex_halo.bring(since);
      MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, g.comm);
    }
    for_each(g.own_vertices, [&](int i, int j, int k) {
      const Int3 v{i, j, k};
      if (!lines.fluid(v) || since(i, j, k) == kNoWall) return;
      double above = kNoWall;
      if (!periodic && v[d] == n)
        above = lines.at_side_wall(2 * d + 1, v) ? 0 : kNoWall;
      else
        above = lines.to_wall(v, true);
      if (above == kNoWall) return;
      const double length = since(i, j, k) + above, cells = length / g.width(d, std::min(v[d], n - 1));
      if (!(cells < narrowest) || cells < kTouching || length > 0.999 * g.grid.axis[d].length()) return;
      // Across the opening: nothing is much nearer to its middle than its ends.
      Vec3 middle;
      double room = length;
      for (int e = 0; e < 3; ++e) middle[e] = g.inner_node(e, v[e]);
      middle[d] += 0.5 * length - since(i, j, k);
      if (periodic && middle[d] < g.grid.axis[d].lo()) middle[d] += g.grid.axis[d].length();
      room = std::min(room, surfaces.nearest(middle, length).distance);
      if (room > 0.35 * length) narrowest = cells;
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, &narrowest, 1, MPI_DOUBLE, MPI_MIN, g.comm);
  return narrowest < kNoWall ? narrowest : 0;
}

}  // namespace twogrid
