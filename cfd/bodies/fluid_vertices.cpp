#include "cfd/bodies/fluid_vertices.h"

#include <algorithm>
#include <stdexcept>

#include "cfd/bodies/sentences.h"

namespace twogrid {

namespace {

/// What is known of the parts, by all ranks.
struct PartTable {
  enum { kSolid, kKnownFluid, kInlet, kOutlet, kHeld, kParticles, kColumns };
  explicit PartTable(int parts) : mark(std::size_t(parts) * kColumns, 0) {}
  int& at(int part, int column) { return mark[std::size_t(part) * kColumns + column]; }
  void share(MPI_Comm comm) { MPI_Allreduce(MPI_IN_PLACE, mark.data(), int(mark.size()), MPI_INT, MPI_MAX, comm); }
  std::vector<int> mark;
};

/// Calls f(part, kind) for the parts that reach an own face of a side where fluid may pass.
template <class F>
void for_each_reached(const LocalGrid& g, const CutEdges& edges, const ConnectedParts& parts, F&& f) {
  for (int side = 0; side < 6; ++side) {
    const int d = direction(side), e = (d + 1) % 3, t = (d + 2) % 3, n = g.grid.axis[d].n();
    Box own = g.own_faces[d];
    own.lo[d] = std::max(own.lo[d], is_high(side) ? n : 0), own.hi[d] = std::min(own.hi[d], is_high(side) ? n + 1 : 1);
    if (g.grid.axis[d].periodic() || own.size(d) == 0) continue;
    for_each(own, [&](int i, int j, int k) {
      const Int3 face{i, j, k};
      if (!g.passes(side, face)) return;
      const BoundaryKind kind = g.settings.side[side][g.condition(side, face)].kind;
      int part[4];
      bool one = true;
      for (int q = 0; q < 4; ++q) {
        Int3 v = face;
        v[e] += q & 1, v[t] += q >> 1;
        part[q] = parts.at(v[0], v[1], v[2]);
        one = one && part[q] >= 0 && part[q] == part[0];
      }
      const unsigned joined = one ? 1u : edges.joined_corners(d, face);
      for (int q = 0; q < 4; ++q)
        if (joined >> q & 1 && part[q] >= 0) f(part[q], kind);
    });
  }
}

/// Own vertices around the cell that holds the point which an uncrossed way along the axes joins to it.
std::vector<Int3> joined_vertices(const LocalGrid& g, const Surfaces& surfaces, const Vec3& point) {
  std::vector<Int3> found;
  Int3 c;
  for (int d = 0; d < 3; ++d) c[d] = g.grid.axis[d].find(point[d]);
  if (!g.cells.contains(c[0], c[1], c[2])) return found;
  static constexpr int kOrder[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int q = 0; q < 8; ++q) {
    const Int3 v{c[0] + (q & 1), c[1] + (q >> 1 & 1), c[2] + (q >> 2)};
    for (const auto& order : kOrder) {
      Vec3 x = point;
      bool open = true;
      for (int d : order) {
        const double to = g.grid.axis[d].node(v[d]) + g.inner_node(d, v[d]) - g.node(d, v[d]);
        open = open && surfaces.first_crossing(x, d, to - x[d]).body < 0;
        x[d] = to;
      }
      if (open) {
        found.push_back(v);
        break;
      }
    }
  }
  return found;
}

/// Marks the parts that hold the settings' points, and returns the vertices that told.
std::vector<Int3> mark_held(const LocalGrid& g, const Surfaces& surfaces, const ConnectedParts& parts,
                            PartTable& table) {
  std::vector<Int3> held;
  const auto& points = g.settings.fluid_at;
  std::vector<int> found(points.size(), 0);
  std::string wrong;
  for (std::size_t p = 0; p < points.size() && wrong.empty(); ++p) {
    const Vec3& x = points[p];
    for (int d = 0; d < 3; ++d)
      if (!(x[d] >= g.grid.axis[d].lo() && x[d] <= g.grid.axis[d].hi()))
        wrong = "fluid_at " + words(x) + " lies outside the fluid's domain; wanted: a point inside it";
    if (wrong.empty() && surfaces.side(x) == SolidShape::Side::kSolid)
      wrong = "fluid_at " + words(x) + " lies in a body's solid; wanted: a point of the fluid";
    Vec3 in = x;
    for (int d = 0; d < 3; ++d)  // a point on the upper side belongs to the last cell
      in[d] = std::min(
          in[d], g.grid.axis[d].node(g.grid.axis[d].n() - 1) + 0.999 * g.grid.axis[d].width(g.grid.axis[d].n() - 1));
    for (const Int3& v : joined_vertices(g, surfaces, in)) {
      const int part = parts.at(v[0], v[1], v[2]);
      if (part < 0) continue;
      found[p] = 1, table.at(part, PartTable::kHeld) = 1;
      if (g.own_vertices.contains(v[0], v[1], v[2])) held.push_back(v);
    }
  }
  refuse_together(g.comm, wrong);
  MPI_Allreduce(MPI_IN_PLACE, found.data(), int(found.size()), MPI_INT, MPI_MAX, g.comm);
  for (std::size_t p = 0; p < points.size(); ++p)
    if (!found[p])
      throw std::invalid_argument(
          "fluid_at " + words(points[p]) +
          " lies in a gap that is narrower than a cell; wanted: a point with room around it, or "
          "finer cells");
  return held;
}

/// Marks the parts in which particles lie.
void mark_particles(const LocalGrid& g, const Surfaces& surfaces, const ConnectedParts& parts, PartTable& table) {
  for (const Vec3& x : g.settings.particles_at) {
    bool inside = true;
    for (int d = 0; d < 3; ++d) inside = inside && x[d] >= g.grid.axis[d].lo() && x[d] < g.grid.axis[d].hi();
    if (!inside) continue;
    for (const Int3& v : joined_vertices(g, surfaces, x))
      if (const int part = parts.at(v[0], v[1], v[2]); part >= 0) table.at(part, PartTable::kParticles) = 1;
  }
}

Vec3 place_of(const LocalGrid& g, long long number) {
  const Int3 n = g.grid.n();
  const Int3 v{int(number % (n[0] + 1)), int(number / (n[0] + 1) % (n[1] + 1)), int(number / (n[0] + 1) / (n[1] + 1))};
  Vec3 x;
  for (int d = 0; d < 3; ++d) {
    const double inwards = LocalGrid::kInwards * g.grid.axis[d].width(std::min(v[d], n[d] - 1));
    x[d] = g.grid.axis[d].node(v[d]);
    if (!g.grid.axis[d].periodic()) x[d] += v[d] == 0 ? inwards : v[d] == n[d] ? -inwards : 0;
  }
  return x;
}

/// Whether each part is fluid, and what told it. The same on all ranks.
std::vector<bool> choose(const LocalGrid& g, const ConnectedParts& parts, PartTable& t, std::string& told_by) {
  const int n = parts.count();
  std::vector<bool> fluid(n, false);
  if (!g.settings.fluid_at.empty()) {
    for (int p = 0; p < n; ++p) fluid[p] = t.at(p, PartTable::kHeld) && !t.at(p, PartTable::kSolid);
    told_by = "where fluid_at says";
    return fluid;
  }
  std::vector<int> through, ends, unknown;  // parts of which no shape knows: with inlet and outlet, with one of them
  for (int p = 0; p < n; ++p) {
    if (t.at(p, PartTable::kSolid)) continue;
    if (t.at(p, PartTable::kKnownFluid)) {
      fluid[p] = true;
      continue;
    }
    unknown.push_back(p);
    const bool in = t.at(p, PartTable::kInlet), out = t.at(p, PartTable::kOutlet);
    if (in && out) through.push_back(p);
    if (in || out) ends.push_back(p);
  }
  const bool known = std::find(fluid.begin(), fluid.end(), true) != fluid.end();
  std::vector<int> best = !through.empty() ? through : ends;
  told_by = !through.empty()  ? "what an inlet and an outlet reach"
            : !ends.empty()   ? "what an inlet or an outlet reaches"
            : known           ? "where no region is solid"
            : unknown.empty() ? "nowhere"
                              : "all of the closed domain";
  if (best.size() > 1 || (best.empty() && unknown.size() > 1 && !known)) {
    std::vector<int> with;
    for (int p : best.empty() ? unknown : best)
      if (t.at(p, PartTable::kParticles)) with.push_back(p);
    if (with.size() == 1) best = with, told_by = "where the particles are, as inlets and outlets don't tell";
  }
  if (best.size() > 1 || (best.empty() && unknown.size() > 1 && !known)) {
    const std::vector<int>& open = best.empty() ? unknown : best;
    throw std::invalid_argument(
        "which side of the bodies' surfaces the fluid is on can't be told: the parts of the domain at " +
        words(place_of(g, parts.first(open[0]))) + " and " + words(place_of(g, parts.first(open[1]))) +
        (best.empty() ? " reach no inlet or outlet" : " both reach an inlet or an outlet") +
        ", and particles don't tell either; wanted: the keyword fluid_at x y z with a point of the fluid");
  }
  for (int p : best) fluid[p] = true;
  if (best.empty() && !known)
    for (int p : unknown) fluid[p] = true;
  return fluid;
}

}  // namespace

FluidVertices find_fluid(const LocalGrid& g, const Surfaces& surfaces, const CutEdges& edges) {
  const ConnectedParts parts(
      g, g.own_vertices, g.vertices, g.vertex_halo, [&](int i, int j, int k) { return !edges.on_surface(i, j, k); },
      [&](int d, int i, int j, int k) { return edges.at(d, i, j, k) == nullptr; });
  PartTable table(parts.count());
  for (int p = 0; p < parts.count(); ++p) {
    const SolidShape::Side side = surfaces.side(place_of(g, parts.first(p)));
    table.at(p, PartTable::kSolid) = side == SolidShape::Side::kSolid;
    table.at(p, PartTable::kKnownFluid) = side == SolidShape::Side::kFluid;
  }
  for_each_reached(g, edges, parts, [&](int part, BoundaryKind kind) {
    table.at(part, kind == BoundaryKind::kInlet ? PartTable::kInlet : PartTable::kOutlet) = 1;
  });
  FluidVertices vertices;
  vertices.held = mark_held(g, surfaces, parts, table);
  mark_particles(g, surfaces, parts, table);
  table.share(g.comm);
  const std::vector<bool> fluid = choose(g, parts, table, vertices.told_by);
  vertices.kind.reset(g.vertices, VertexKind::kSolid);
  vertices.part.reset(g.vertices, -1);
  vertices.parts = parts.count();
  for_each(g.vertices, [&](int i, int j, int k) {
    const int part = vertices.part(i, j, k) = parts.at(i, j, k);
    if (part >= 0 && fluid[part]) vertices.kind(i, j, k) = VertexKind::kFluid;
    if (edges.on_surface(i, j, k)) vertices.kind(i, j, k) = VertexKind::kOnSurface;
  });
  return vertices;
}

}  // namespace twogrid
