// Cuts the fluid's grid by the surfaces of bodies: open shares of faces and cells, links between faces that no wall
// parts, friction of the walls. Distance-link finite volumes: every wall a face feels stands on the diagonal.
//
//   vertices   joined by an edge that no surface crosses have one label; fluid are the labels that reach an inlet, an
//              outlet or a point of fluid_at, where that leaves a choice those that hold particles; what a shape knows of
//              its own sides comes first
//   alpha      of a face: the polygon of its fluid corners and of the first crossings from them
//   theta      of a cell: the polyhedron of the same points
//   A_w        of a cell: |sum of alpha A n over its faces|, so that its open surface closes
//   fluid      a face's centre that an uncrossed way along the axes joins to a fluid corner; else open faces are slivers
//   friction   fluid face, link cut after eta h:   a A/(eta h)          a: mean of the two cells' alpha, or of alpha
//              fluid face, its own wall:           A_w/phi              of the two faces along its own direction
//              sliver:                             A_w/(distance of the open part's centroid)
//              with A_w the mean of the two cells'; eta >= 0.01, distances >= 0.01 h; the velocity is that of the open
//              part, so that links take it times OpenSpace::centre, and all of a fluid face times OpenSpace::viscous
// Sheets close whole faces (sheets.h); they have no part in labels.
// Cleaned: alpha below 1e-3 is closed; cells without an open face are closed; so are pockets that reach no inlet, outlet
// or point of fluid_at, unless the whole domain is closed.
#pragma once

#include <mpi.h>

#include <array>
#include <string>
#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/fluid_settings.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

/// What the report says of it; the same on all ranks.
struct CutReport {
  struct OfBody {
    std::string name;
    double area = 0;      ///< of its surface in the fluid as resolved (m2)
    double volume = 0;    ///< closed by it, inside the domain (m3)
    long long cells = 0;  ///< cut by it
    double blown = 0;     ///< of its area, that blows (m2)
  };
  std::vector<OfBody> bodies;
  double open_volume = 0;                                   ///< m3
  std::array<std::vector<double>, 3> open_layers;           ///< the same by layers of cells along x, y, z (m3)
  long long sheet_faces = 0;                                ///< closed by sheets
  long long closed_cells = 0, slivers = 0, thin_edges = 0;  ///< thin: edges that are crossed twice or more
  std::string fluid_side;                                   ///< what told which parts of the domain are fluid, in words
  double pocket_volume = 0;                                 ///< closed because nothing leads there (m3)
  double narrowest = 0;  ///< cells across the narrowest opening between walls, as the axes see it
};

/// Fills the shares of own faces and cells, which on entry are all open. Collective. Throws std::invalid_argument with a
/// sentence, on all ranks, where the bodies can't be.
CutReport cut_grid(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings,
                   OpenSpace& space);

}  // namespace twogrid
