#include "cfd/bodies/sheets.h"

#include <stdexcept>

namespace twogrid {

namespace {

constexpr double kAbove = 1e-6;  // of a cell's width

}  // namespace

long long close_sheets(const LocalGrid& g, const Surfaces& sheets, FaceField<FineGrid>& alpha, Array3<char>& beside) {
  const auto& bodies = sheets.bodies();
  beside.reset(g.cells, 0);
  bool any = false;
  for (const Body& b : bodies) any = any || b.sheet;
  if (!any) return 0;
  std::vector<long long> closed(bodies.size(), 0);
  FaceField<FineGrid> met;
  for (int d = 0; d < 3; ++d) {
    met[d].reset(g.faces[d]);
    if (!g.solved[d]) continue;
    for_each(g.own_faces[d], [&](int i, int j, int k) {
      const Int3 cell{i, j, k};
      if (g.side_of(d, cell[d]) >= 0) return;
      Vec3 x;
      for (int e = 0; e < 3; ++e) x[e] = g.centre(e, cell[e]);
      // From a little above one centre to a little above the other, as the next faces do: what stands on a centre closes
      // one of its two faces.
      const double own = g.width(d, cell[d]), below = g.width(d, cell[d] - 1);
      x[d] += kAbove * own;
      const int body = sheets.first_crossing(x, d, -0.5 * (below + own) - kAbove * (own - below)).body;
      if (body < 0) return;
      met[d](i, j, k) = 1;
      ++closed[body];
    });
  }
  g.face_halo.bring(met);
  for (int d = 0; d < 3; ++d)
    for_each(g.faces[d], [&](int i, int j, int k) {
      if (met[d](i, j, k) == 0) return;
      alpha[d](i, j, k) = 0;
      Int3 cell{i, j, k};
      for (int below = 0; below < 2; ++below, --cell[d])
        if (g.cells.contains(cell[0], cell[1], cell[2])) beside(cell[0], cell[1], cell[2]) = 1;
    });
  MPI_Allreduce(MPI_IN_PLACE, closed.data(), int(closed.size()), MPI_LONG_LONG, MPI_SUM, g.comm);
  long long all = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    all += closed[b];
    if (bodies[b].sheet && closed[b] == 0)
      throw std::invalid_argument(
          "sheet '" + bodies[b].name +
          "' stands between no two cells of the fluid's grid: it lies outside the fluid's "
          "domain, at its sides, or is smaller than a cell; wanted: one inside, some cells large");
  }
  return all;
}

}  // namespace twogrid
