#include "cfd/bodies/cut_grid.h"

#include <cmath>

#include "cfd/bodies/clean_up.h"
#include "cfd/bodies/cut_faces.h"
#include "cfd/bodies/wall_links.h"

namespace twogrid {

CutReport cut_grid(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings,
                   OpenSpace& space) {
  const LocalGrid local(comm, grid, layout, settings);
  const Surfaces surfaces(grid, settings.bodies);
  const CutEdges edges(local, surfaces);
  const FluidVertices vertices = find_fluid(local, surfaces, edges);
  const CutFaces faces(local, edges, vertices);
  FaceField<FineGrid> alpha;
  for (int d = 0; d < 3; ++d) {
    alpha[d].reset(local.faces[d]);
    for_each(local.faces[d], [&](int i, int j, int k) { alpha[d](i, j, k) = faces.open(d, {i, j, k}).share; });
  }
  CellField<FineGrid> theta(local.cells);
  for_each(local.cells, [&](int i, int j, int k) { theta(i, j, k) = faces.open_share({i, j, k}, alpha); });
  CleanUp clean(local, alpha, theta);
  clean.close_slivers();
  CutReport report;
  report.pocket_volume = clean.close_pockets(vertices.held);
  const WallLinks links(local, surfaces, edges, faces, alpha, theta);
  for (int d = 0; d < 3; ++d)
    for_each(local.own_faces[d], [&](int i, int j, int k) { space.alpha[d](i, j, k) = alpha[d](i, j, k); });
  for_each(local.own, [&](int i, int j, int k) { space.theta(i, j, k) = theta(i, j, k); });
  links.fill(space);

  const std::size_t bodies = settings.bodies.size();
  std::vector<double> sums(3 + 2 * bodies, 0.0);
  sums[0] = double(links.slivers());
  for_each(local.own, [&](int i, int j, int k) {
    sums[1] += theta(i, j, k) * local.volume({i, j, k});
    sums[2] += theta(i, j, k) == 0;
  });
  for (const WallCell& w : space.surface) {
    sums[3 + 2 * w.body] += std::sqrt(w.area[0] * w.area[0] + w.area[1] * w.area[1] + w.area[2] * w.area[2]);
    sums[4 + 2 * w.body] += 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  report.slivers = static_cast<long long>(sums[0]);
  report.open_volume = sums[1];
  report.closed_cells = static_cast<long long>(sums[2]);
  for (std::size_t b = 0; b < bodies; ++b)
    report.bodies.push_back({settings.bodies[b].name, sums[3 + 2 * b], 0, static_cast<long long>(sums[4 + 2 * b])});
  return report;
}

}  // namespace twogrid
