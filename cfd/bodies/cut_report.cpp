#include "cfd/bodies/cut_report.h"

#include <cmath>
#include <map>

namespace twogrid {

namespace {

/// Body of every part of the solid: whose surface parts it from the fluid, at most places; -1: of none.
std::vector<int> bodies_of_parts(const LocalGrid& g, const Surfaces& surfaces, const CutEdges& edges,
                                 const FluidVertices& vertices) {
  std::map<std::array<int, 2>, long long> votes;
  for_each(g.own_vertices, [&](int i, int j, int k) {
    const Int3 v{i, j, k};
    const VertexKind kind = vertices(i, j, k);
    int body = -1;
    if (kind == VertexKind::kOnSurface) {
      Vec3 x;
      double width = 0;
      for (int d = 0; d < 3; ++d) x[d] = g.inner_node(d, v[d]), width += g.width(d, std::min(v[d], g.cells.hi[d] - 1));
      body = surfaces.nearest(x, width).body;
    }
    if (kind == VertexKind::kSolid) return;
    for (int d = 0; d < 3; ++d)
      for (int up = 0; up < 2; ++up) {
        Int3 next = v, low = v;
        next[d] += up ? 1 : -1;
        if (!up) --low[d];
        if (!g.vertices.contains(next[0], next[1], next[2]) ||
            vertices(next[0], next[1], next[2]) != VertexKind::kSolid)
          continue;
        int whose = body;
        if (const Crossing* c = edges.at(d, low[0], low[1], low[2])) whose = up ? c->body_low : c->body_high;
        if (whose >= 0) ++votes[{vertices.part(next[0], next[1], next[2]), whose}];
      }
  });
  std::vector<long long> mine;
  for (const auto& vote : votes) mine.insert(mine.end(), {vote.first[0], vote.first[1], vote.second});
  votes.clear();
  const std::vector<long long> all = gathered(g.comm, mine);
  for (std::size_t q = 0; q < all.size(); q += 3) votes[{int(all[q]), int(all[q + 1])}] += all[q + 2];
  std::vector<int> body(vertices.parts, -1);
  std::vector<long long> most(vertices.parts, 0);
  for (const auto& vote : votes)
    if (vote.second > most[vote.first[0]]) most[vote.first[0]] = vote.second, body[vote.first[0]] = vote.first[1];
  return body;
}

double size(const Vec3& a) {
  return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

}  // namespace

void sum_up(const LocalGrid& g, const Surfaces& surfaces, const CutEdges& edges, const FluidVertices& vertices,
            const OpenSpace& space, CutReport& report) {
  const std::vector<int> body_of = bodies_of_parts(g, surfaces, edges, vertices);
  const std::size_t n = surfaces.bodies().size();
  enum { kOpen, kClosed, kSlivers, kCommon, kArea = 0, kVolume, kCells, kBlown, kOfBody };
  std::vector<double> sum(kCommon + n * kOfBody, 0.0);
  const auto of = [&](int body, int what) -> double& { return sum[kCommon + std::size_t(body) * kOfBody + what]; };
  for (int d = 0; d < 3; ++d) report.open_layers[d].assign(g.grid.axis[d].n(), 0.0);
  for (int d = 0; d < 3; ++d)
    for_each(g.own_faces[d], [&](int i, int j, int k) {
      if (space.links[d](i, j, k) & OpenSpace::kSliver) ++sum[kSlivers];
    });
  for (const OpenSpace::BlownCell& c : space.blown_cells) of(c.body, kBlown) += c.size;
  for (const WallCell& w : space.surface) of(w.body, kArea) += size(w.area), ++of(w.body, kCells);
  for_each(g.own, [&](int i, int j, int k) {
    const Int3 cell{i, j, k};
    const double V = g.volume(cell), closed = 1 - space.theta(i, j, k);
    sum[kOpen] += (1 - closed) * V;
    for (int d = 0; d < 3; ++d) report.open_layers[d][cell[d]] += (1 - closed) * V;
    if (closed == 1) ++sum[kClosed];
    if (!(closed > 0)) return;
    int body = -1;
    for (int q = 0; q < 8 && body < 0; ++q) {
      const Int3 v{i + (q & 1), j + (q >> 1 & 1), k + (q >> 2)};
      if (vertices(v[0], v[1], v[2]) == VertexKind::kSolid) body = body_of[vertices.part(v[0], v[1], v[2])];
    }
    if (body < 0) {
      Vec3 x;
      double reach = 0;
      for (int d = 0; d < 3; ++d) x[d] = g.centre(d, cell[d]), reach += g.width(d, cell[d]);
      body = surfaces.nearest(x, reach).body;
    }
    if (body >= 0) of(body, kVolume) += closed * V;
  });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(sum.size()), MPI_DOUBLE, MPI_SUM, g.comm);
  for (std::vector<double>& layers : report.open_layers)
    MPI_Allreduce(MPI_IN_PLACE, layers.data(), int(layers.size()), MPI_DOUBLE, MPI_SUM, g.comm);
  report.open_volume = sum[kOpen];
  report.closed_cells = static_cast<long long>(sum[kClosed]);
  report.slivers = static_cast<long long>(sum[kSlivers]);
  for (std::size_t b = 0; b < n; ++b)
    report.bodies.push_back({surfaces.bodies()[b].name, of(int(b), kArea), of(int(b), kVolume),
                             static_cast<long long>(of(int(b), kCells)), of(int(b), kBlown)});
}

}  // namespace twogrid
