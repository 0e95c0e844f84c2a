#include "cfd/fluid/domain.h"

namespace twogrid {

namespace {

int rank_of(MPI_Comm comm) {
  int r;
  MPI_Comm_rank(comm, &r);
  return r;
}

std::vector<Box> with_halo(const std::vector<Box>& cells, const Int3& halo) {
  std::vector<Box> wanted;
  for (const Box& b : cells) wanted.push_back(b.empty() ? Box{} : b.grown(halo));
  return wanted;
}

}  // namespace

FluidDomain::FluidDomain(MPI_Comm c, const FineGrid& g, const Layout& l, const FluidSettings& settings)
    : comm(c),
      rank(rank_of(c)),
      grid(g),
      layout(l),
      own(layout.cells(rank)),
      boundaries(comm, grid, layout, settings),
      local(boundaries.local()),
      faces{own.empty() ? Box{} : layout.faces(0, rank), own.empty() ? Box{} : layout.faces(1, rank),
            own.empty() ? Box{} : layout.faces(2, rank)},
      solved{boundaries.component_solved(0), boundaries.component_solved(1), boundaries.component_solved(2)},
      measures(grid, own, local),
      cell_halo(comm, layout.all_cells(), with_halo(layout.all_cells(), boundaries.halo()), grid.n(), grid.periodic()),
      face_halo(comm, {layout.all_faces(0), layout.all_faces(1), layout.all_faces(2)},
                {with_halo(layout.all_cells(), boundaries.halo()), with_halo(layout.all_cells(), boundaries.halo()),
                 with_halo(layout.all_cells(), boundaries.halo())},
                grid.n(), grid.periodic()),
      settings_(settings) {}

void FluidDomain::fill(FaceField<FineGrid>& u) const {
  face_halo.bring(u);
  boundaries.apply(u);
}

void FluidDomain::fill(CellField<FineGrid>& c) const {
  cell_halo.bring<double>(c);
}

void FluidDomain::extend(CellField<FineGrid>& c) const {
  fill(c);
  for (int d = 0; d < 3; ++d) {
    if (grid.axis[d].periodic()) continue;
    const int n = grid.axis[d].n();
    for (bool high : {false, true}) {
      Box beyond = local;
      (high ? beyond.lo[d] : beyond.hi[d]) = high ? std::max(local.lo[d], n) : std::min(local.hi[d], 0);
      for_each(beyond, [&](int i, int j, int k) {
        Int3 inner{i, j, k};
        inner[d] = high ? n - 1 : 0;
        c(i, j, k) = c(inner[0], inner[1], inner[2]);
      });
    }
  }
}

double FluidDomain::volume() const {
  double volume = 1;
  for (int d = 0; d < 3; ++d) volume *= grid.axis[d].length();
  return volume;
}

double FluidDomain::cells() const {
  return double(grid.n()[0]) * grid.n()[1] * grid.n()[2];
}

bool FluidDomain::has(int side, BoundaryKind kind) const {
  for (const BoundaryCondition& c : settings_.side[side])
    if (c.kind == kind) return true;
  return false;
}

}  // namespace twogrid
