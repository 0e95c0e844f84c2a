#include "cfd/bodies/cut_grid.h"

#include "cfd/bodies/clean_up.h"
#include "cfd/bodies/cut_faces.h"
#include "cfd/bodies/cut_report.h"
#include "cfd/bodies/opening.h"
#include "cfd/bodies/refusals.h"
#include "cfd/bodies/sheets.h"
#include "cfd/bodies/wall_links.h"
#include "cfd/bodies/wall_outlines.h"

namespace twogrid {

CutReport cut_grid(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings,
                   OpenSpace& space) {
  const LocalGrid local(comm, grid, layout, settings);
  const Surfaces surfaces(grid, settings.bodies), solids(grid, settings.bodies, Surfaces::Which::kSolids);
  const CutEdges edges(local, solids);
  const FluidVertices vertices = find_fluid(local, solids, edges);
  CutReport report;
  report.fluid_side = vertices.told_by;
  report.thin_edges = refuse_unresolved(local, solids, edges, vertices);
  const CutFaces faces(edges, vertices);
  FaceField<FineGrid> alpha;
  for (int d = 0; d < 3; ++d) {
    alpha[d].reset(local.faces[d]);
    for_each(local.faces[d], [&](int i, int j, int k) { alpha[d](i, j, k) = faces.open(d, {i, j, k}).share; });
  }
  CellField<FineGrid> theta(local.cells);
  for_each(local.cells, [&](int i, int j, int k) { theta(i, j, k) = faces.open_share({i, j, k}, alpha); });
  Array3<char> beside_sheets;
  report.sheet_faces =
      close_sheets(local, Surfaces(grid, settings.bodies, Surfaces::Which::kSheets), alpha, beside_sheets);
  CleanUp clean(local, alpha, theta);
  clean.close_slivers();
  report.pocket_volume = clean.close_pockets(vertices.held);
  const WallLinks links(local, surfaces, edges, faces, alpha, theta, beside_sheets);
  for (int d = 0; d < 3; ++d)
    for_each(local.own_faces[d], [&](int i, int j, int k) { space.alpha[d](i, j, k) = alpha[d](i, j, k); });
  for_each(local.own, [&](int i, int j, int k) { space.theta(i, j, k) = theta(i, j, k); });
  links.fill(space);
  if (settings.wall_stress) outline_walls(local, faces, alpha, space);

  refuse_covered(local, alpha);
  sum_up(local, surfaces, edges, vertices, space, report);
  report.narrowest = narrowest_opening(local, solids, edges, vertices);
  return report;
}

}  // namespace twogrid
