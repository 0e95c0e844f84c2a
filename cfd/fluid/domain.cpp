#include "cfd/fluid/domain.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/parallel/ranks.h"

namespace twogrid {

FluidDomain::FluidDomain(MPI_Comm c, const FineGrid& g, const Layout& l, const FluidSettings& settings)
    : comm(c),
      rank(rank_of(c)),
      grid(g),
      layout(l),
      own(layout.cells(rank)),
      boundaries(comm, grid, layout, settings),
      local(boundaries.local()),
      faces{layout.faces(0, rank), layout.faces(1, rank), layout.faces(2, rank)},
      solved{boundaries.component_solved(0), boundaries.component_solved(1), boundaries.component_solved(2)},
      measures(grid, own, local),
      cell_halo(comm, layout.all_cells(), with_halo(layout.all_cells(), boundaries.halo()), grid.n(), grid.periodic()),
      face_halo(comm, {layout.all_faces(0), layout.all_faces(1), layout.all_faces(2)},
                {with_halo(layout.all_cells(), boundaries.halo()), with_halo(layout.all_cells(), boundaries.halo()),
                 with_halo(layout.all_cells(), boundaries.halo())},
                grid.n(), grid.periodic()),
      settings_(settings) {
  if (settings_.open_space) make_open_shares();
}

/// Takes the shares from the settings' model, refuses those that can't be right, and brings them to the halo.
void FluidDomain::make_open_shares() {
  OpenSpace space;
  for (int d = 0; d < 3; ++d) space.alpha[d].reset(faces[d], 1.0);
  space.theta.reset(own, 1.0);
  settings_.open_space(grid, space);
  FaceField<FineGrid> alpha, theta_f, friction;
  CellField<FineGrid> theta(local, 1.0);
  bool rubs = false;
  double bad[2] = {0, 0}, open = 0;  // shares that are none, frictions that are none
  for (int d = 0; d < 3; ++d) {
    rubs = rubs || space.friction[d].size() > 0;
    alpha[d].reset(local, 1.0), theta_f[d].reset(local, 1.0);
    for_each(faces[d], [&](int i, int j, int k) {
      const double a = alpha[d](i, j, k) = space.alpha[d](i, j, k);
      if (!(a >= 0 && a <= 1)) ++bad[0];
    });
  }
  for_each(own, [&](int i, int j, int k) {
    const double t = theta(i, j, k) = space.theta(i, j, k);
    open += t * measures.cell_volume(i, j, k);
    if (!(t >= 0 && t <= 1)) ++bad[0];
  });
  for (int d = 0; rubs && d < 3; ++d) {
    friction[d].reset(local);
    if (space.friction[d].size() > 0)
      for_each(faces[d], [&](int i, int j, int k) {
        const double K = friction[d](i, j, k) = space.friction[d](i, j, k);
        if (!(K >= 0 && std::isfinite(K))) ++bad[1];
      });
  }
  extend(theta);
  extend_faces(alpha);
  measures.face_mean(theta, theta_f);
  extend_faces(theta_f);
  double apart[2] = {0, 0};  // open faces beside a closed cell, cells without an open face
  for (int d = 0; d < 3; ++d)
    for_each(faces[d], [&](int i, int j, int k) {
      const std::ptrdiff_t m = theta.index(i, j, k);
      if (solved[d] && alpha[d].data()[m] > 0 && !(theta.data()[m] > 0 && theta.data()[m - theta.stride(d)] > 0))
        ++apart[0];
    });
  for_each(own, [&](int i, int j, int k) {
    const std::ptrdiff_t m = theta.index(i, j, k);
    double any = 0;
    for (int d = 0; d < 3; ++d)
      if (solved[d]) any += alpha[d].data()[m] + alpha[d].data()[m + alpha[d].stride(d)];
    if (theta.data()[m] > 0 && !(any > 0)) ++apart[1];
  });
  double sums[5] = {bad[0], bad[1], apart[0], apart[1], open};
  MPI_Allreduce(MPI_IN_PLACE, sums, 5, MPI_DOUBLE, MPI_SUM, comm);
  const char* const wrong[4] = {"open shares of faces and cells are not between 0 and 1; wanted: 0 closed to 1 open",
                                "frictions of faces are below zero or not finite; wanted: 1/m2, at least 0",
                                "faces are open beside a closed cell; wanted: closed faces around every closed cell",
                                "cells are open but none of their faces is; wanted: such cells closed"};
  for (int q = 0; q < 4; ++q)
    if (sums[q] > 0) {
      std::ostringstream text;
      text << "the bodies in the fluid's grid can't be: " << sums[q] << " " << wrong[q];
      throw std::invalid_argument(text.str());
    }
  if (!(sums[4] > 0))
    throw std::invalid_argument("the bodies leave no room for the fluid; wanted: some open cells in its domain");
  measures.set_open(std::make_unique<const OpenShares>(measures, local, alpha, std::move(theta), std::move(theta_f),
                                                       std::move(friction), sums[4]));
  boundaries.close_faces(comm, *measures.open());
}

/// Halo, and beyond the domain's sides the value of the face inside. Collective.
void FluidDomain::extend_faces(FaceField<FineGrid>& f) const {
  face_halo.bring(f);
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) {
      if (grid.axis[d].periodic()) continue;
      const int last = grid.axis[d].n() - (c == d ? 0 : 1);
      for_each(local, [&](int i, int j, int k) {
        Int3 inner{i, j, k};
        inner[d] = std::min(std::max(inner[d], 0), last);
        if (inner[d] != Int3{i, j, k}[d]) f[c](i, j, k) = f[c](inner[0], inner[1], inner[2]);
      });
    }
}

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
  if (measures.open()) return measures.open()->volume();
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
