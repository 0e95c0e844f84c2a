#include "cfd/bodies/refusals.h"

#include <algorithm>
#include <climits>
#include <sstream>
#include <stdexcept>

#include "cfd/bodies/sentences.h"

namespace twogrid {

namespace {

std::string quoted(const Body& b) {
  return "'" + b.name + "'";
}

/// Edges with fluid at both ends that a surface crosses: once (a sheet, unless a body only touches the edge), or twice; with no vertex around inside the body.
struct Unresolved {
  long long count = 0, first = LLONG_MAX;  // first: the edge with the smallest number
  Vec3 place{0, 0, 0};
  int body = 0;
  void add(const LocalGrid& g, int d, const Int3& v, const Crossing& c) {
    ++count;
    const long long number = 3 * g.number(v[0], v[1], v[2]) + d;
    if (number >= first) return;
    first = number, body = c.body_low;
    for (int e = 0; e < 3; ++e) place[e] = g.node(e, v[e]);
    place[d] += c.low * g.width(d, v[d]);
  }
};

/// Whether a vertex of the cells around an edge is in the solid, or on a surface where that counts.
bool solid_near(const LocalGrid& g, const FluidVertices& vertices, int d, const Int3& v, bool or_on_surface) {
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      for (int up = 0; up < 2; ++up) {
        Int3 w = v;
        w[e] += a, w[f] += b, w[d] += up;
        if (!g.vertices.contains(w[0], w[1], w[2])) continue;
        const VertexKind kind = vertices(w[0], w[1], w[2]);
        if (kind == VertexKind::kSolid || (or_on_surface && kind == VertexKind::kOnSurface)) return true;
      }
  return false;
}

void refuse(const LocalGrid& g, Unresolved bad, const std::string& before, const std::string& after) {
  long long first = bad.first, count = bad.count;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_LONG_LONG, MPI_MIN, g.comm);
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_LONG_LONG, MPI_SUM, g.comm);
  if (count == 0) return;
  std::ostringstream s;
  if (bad.first == first)
    s << "body " << quoted(g.settings.bodies[bad.body]) << " " << before << " at " << words(bad.place) << " (" << count
      << " edges of the fluid's grid in all); " << after;
  refuse_together(g.comm, s.str());
}

/// Why a body meets no edge of the grid; empty where that is right: it lies in the plane of a side.
std::string why_unmet(const LocalGrid& g, const Body& b) {
  Vec3 lo, hi, low, high;
  b.shape->bounds(lo, hi);
  bool outside = false, known = true;
  for (int d = 0; d < 3; ++d) {
    const Axis& a = g.grid.axis[d];
    low[d] = a.lo(), high[d] = a.hi();
    known = known && lo[d] <= hi[d];
    outside = outside || hi[d] < a.lo() || lo[d] > a.hi();
  }
  if (known && outside)
    return "lies outside the fluid's domain: it reaches from " + words(lo) + " to " + words(hi) + ", the domain from " +
           words(low) + " to " + words(high) + "; wanted: a body inside it (are both in metres?)";
  for (int d = 0; known && d < 3; ++d) {
    const Axis& a = g.grid.axis[d];
    const double slack = 2 * LocalGrid::kInwards * std::max(a.width(0), a.width(a.n() - 1));
    if (hi[d] < a.lo() + slack || lo[d] > a.hi() - slack) return "";
  }
  return "is met by no edge of the fluid's grid: it is thinner than a cell, or its surface lies outside the fluid's "
         "domain; wanted: cells of a third of its width or finer, or a surface that the fluid meets";
}

}  // namespace

long long refuse_unresolved(const LocalGrid& g, const Surfaces& surfaces, const CutEdges& edges,
                            const FluidVertices& vertices) {
  const auto& bodies = surfaces.bodies();
  std::vector<long long> met(bodies.size() + 1, 0);  // and, last, edges that are crossed twice or more
  Unresolved sheet, thin;
  for_each(g.own_vertices, [&](int i, int j, int k) {
    const Int3 v{i, j, k};
    for (int d = 0; d < 3; ++d) {
      if (v[d] + 1 >= g.vertices.hi[d]) continue;
      const Crossing* c = edges.at(d, i, j, k);
      if (!c) continue;
      ++met[c->body_low], ++met[c->body_high];
      if (!c->single()) ++met.back();
      Int3 next = v;
      ++next[d];
      if (vertices(i, j, k) != VertexKind::kFluid || vertices(next[0], next[1], next[2]) != VertexKind::kFluid)
        continue;
      if (!solid_near(g, vertices, d, v, !c->single())) (c->single() ? sheet : thin).add(g, d, v, *c);
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, met.data(), int(met.size()), MPI_LONG_LONG, MPI_SUM, g.comm);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::string why = met[b] > 0 || bodies[b].sheet ? "" : why_unmet(g, bodies[b]);
    if (!why.empty()) throw std::invalid_argument("body " + quoted(bodies[b]) + " " + why);
  }
  refuse(g, sheet, "parts nothing: there is fluid on both sides of its surface",
         "wanted: a closed surface, or one that ends at the domain's sides, with the fluid on one side of it (a mesh "
         "without thickness in the middle of the fluid: the word 'sheet')");
  refuse(g, thin, "is thinner than a cell, with fluid on both sides,",
         "wanted: finer cells there, two or more across it");
  return met.back();
}

void refuse_covered(const LocalGrid& g, const FaceField<FineGrid>& alpha) {
  for (int side = 0; side < 6; ++side) {
    const auto& conditions = g.settings.side[side];
    const int d = direction(side), at = is_high(side) ? g.grid.axis[d].n() : 0;
    if (g.grid.axis[d].periodic() || !g.solved[d] || conditions.empty()) continue;
    std::vector<double> areas(2 * conditions.size(), 0.0);  // whole, open
    Box own = g.own_faces[d];
    own.lo[d] = std::max(own.lo[d], at), own.hi[d] = std::min(own.hi[d], at + 1);
    for_each(own, [&](int i, int j, int k) {
      const std::size_t c = std::size_t(g.condition(side, {i, j, k}));
      areas[2 * c] += g.area(d, {i, j, k}), areas[2 * c + 1] += alpha[d](i, j, k) * g.area(d, {i, j, k});
    });
    MPI_Allreduce(MPI_IN_PLACE, areas.data(), int(areas.size()), MPI_DOUBLE, MPI_SUM, g.comm);
    for (std::size_t c = 0; c < conditions.size(); ++c) {
      const bool in = conditions[c].kind == BoundaryKind::kInlet;
      if (!(areas[2 * c] > 0) || areas[2 * c + 1] > 0 || (!in && conditions[c].kind != BoundaryKind::kPressure))
        continue;
      throw std::invalid_argument("the bodies cover the " + std::string(in ? "inlet" : "outlet") + " " +
                                  (conditions[c].name.empty() ? "" : "'" + conditions[c].name + "' ") + "on side " +
                                  kSideNames[side] +
                                  " wholly: none of its faces is open to the fluid; wanted: a surface that leaves it "
                                  "free, the fluid on the other side of it (fluid_at x y z), or another place for it");
    }
  }
}

}  // namespace twogrid
