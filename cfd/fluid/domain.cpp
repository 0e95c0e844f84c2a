#include "cfd/fluid/domain.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/bodies/cut_grid.h"
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
  if (settings_.open_space || !settings_.bodies.empty()) make_open_shares();
}

/// Takes the shares from the settings' model, refuses those that can't be right, and brings them to the halo.
void FluidDomain::make_open_shares() {
  OpenSpace space;
  OpenShares::Held held;
  for (int d = 0; d < 3; ++d) space.alpha[d].reset(faces[d], 1.0);
  space.theta.reset(own, 1.0);
  if (settings_.open_space)
    settings_.open_space(grid, space);
  else
    cut_ = std::make_unique<const CutReport>(cut_grid(comm, grid, layout, settings_, space));
  FaceField<FineGrid>&alpha = held.alpha, &theta_f = held.theta_f, &friction = held.friction;
  CellField<FineGrid>& theta = held.theta;
  theta.reset(local, 1.0);
  // Alike on all ranks, also where a rank has no cells.
  int has[5] = {!space.pieces.empty() || space.friction[0].size() > 0, space.links[0].size() > 0, !space.pieces.empty(),
                space.centre[0].size() > 0, space.drift[0].size() > 0};
  MPI_Allreduce(MPI_IN_PLACE, has, 5, MPI_INT, MPI_MAX, comm);
  double bad[2] = {0, 0}, open = 0;  // shares that are none, frictions that are none
  for (int d = 0; d < 3; ++d) {
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
  extend(theta);
  extend_faces(alpha);
  measures.face_mean(theta, theta_f);
  extend_faces(theta_f);
  if (has[0]) add_up_friction(space, has[2], held);
  if (has[1]) bring_links(space, held);
  for (int d = 0; has[3] && d < 3; ++d) {
    held.centre[d].reset(local, 1.0), held.viscous[d].reset(local, 1.0);
    for_each(faces[d], [&](int i, int j, int k) {
      held.centre[d](i, j, k) = space.centre[d](i, j, k);
      held.viscous[d](i, j, k) = space.viscous[d](i, j, k);
    });
  }
  if (has[3]) extend_faces(held.centre);
  for (int d = 0; has[4] && d < 3; ++d) {
    held.wall_velocity[d].reset(local), held.drift[d].reset(local);
    for_each(faces[d], [&](int i, int j, int k) {
      held.wall_velocity[d](i, j, k) = space.wall_velocity[d](i, j, k);
      held.drift[d](i, j, k) = space.drift[d](i, j, k);
    });
  }
  if (has[4]) {
    extend_faces(held.wall_velocity);
    // Beyond sides as velocities are: what is at a centre has what its side asks for.
    face_halo.bring(held.drift);
    boundaries.apply(held.drift, true);
  }
  const auto blows = [](const Body& b) { return b.blow.on; };
  const bool blown = std::any_of(settings_.bodies.begin(), settings_.bodies.end(), blows);
  if (blown) bring_blown_faces(space, held);
  for (int d = 0; d < 3; ++d)
    for_each(faces[d], [&](int i, int j, int k) {
      const bool open = alpha[d](i, j, k) > 0;
      if (has[0] && open && !(friction[d](i, j, k) >= 0 && std::isfinite(friction[d](i, j, k)))) ++bad[1];
      // Nothing is carried to closed faces among closed ones.
      const std::ptrdiff_t m = theta.index(i, j, k);
      bool beside = false;
      for (int e = 0; e < 3; ++e)
        beside = beside || alpha[d].data()[m - theta.stride(e)] > 0 || alpha[d].data()[m + theta.stride(e)] > 0;
      if (has[1] && (open ? held.links[d].data()[m] & OpenSpace::kSliver : beside)) held.own[d].push_back(m);
    });
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
  held.slivers = std::move(space.slivers), held.beside = std::move(space.beside);
  held.pieces = std::move(space.pieces), held.surface = std::move(space.surface);
  held.outlines = std::move(space.outlines);
  held.blown_pieces = std::move(space.blown_pieces), held.blown_slivers = std::move(space.blown_slivers);
  held.volume = sums[4];
  auto made = std::make_unique<OpenShares>(measures, local, own, faces, solved, std::move(held));
  shares_ = made.get();
  measures.set_open(std::move(made));
  boundaries.close_faces(comm, *measures.open());
  if (blown) blowing = std::make_unique<Blowing>(*this, settings_.bodies, space.blown_cells);
}

void FluidDomain::bring_blown_faces(const OpenSpace& space, OpenShares::Held& held) const {
  for (int d = 0; d < 3; ++d) {
    held.blown_body[d].reset(local, -1.0), held.blown_velocity[d].reset(local), held.blown_drift[d].reset(local);
    for (const OpenSpace::BlownFace& f : space.blown_faces) {
      if (f.component != d) continue;
      const std::ptrdiff_t m = held.blown_body[d].index(f.face[0], f.face[1], f.face[2]);
      held.blown_body[d].data()[m] = f.body;
      held.blown_velocity[d].data()[m] = f.velocity, held.blown_drift[d].data()[m] = f.drift;
    }
  }
  extend_faces(held.blown_body);
  extend_faces(held.blown_velocity);
  // As with the walls' own drift.
  face_halo.bring(held.blown_drift);
  boundaries.apply(held.blown_drift, true);
}

bool FluidDomain::update_velocities() {
  boundaries.update();
  if (!blowing || !blowing->update(*this)) return false;
  shares_->set_blowing(blowing->velocity());
  return true;
}

/// K' of own faces: of the pieces, where there are any; else as given.
void FluidDomain::add_up_friction(const OpenSpace& space, bool of_pieces, OpenShares::Held& held) const {
  for (int d = 0; d < 3; ++d) {
    held.friction[d].reset(local);
    if (space.friction[d].size() > 0 && !of_pieces)
      for_each(faces[d], [&](int i, int j, int k) { held.friction[d](i, j, k) = space.friction[d](i, j, k); });
  }
  for (const WallPiece& piece : space.pieces) {
    const int c = piece.component;
    const std::ptrdiff_t m = held.theta.index(piece.face[0], piece.face[1], piece.face[2]);
    if (!(held.alpha[c].data()[m] > 0)) continue;
    held.friction[c].data()[m] += piece.conductance / (held.theta_f[c].data()[m] *
                                                       measures.volume(c, piece.face[0], piece.face[1], piece.face[2]));
  }
}

/// Links of own faces and of the halo. Beyond the domain's sides nothing is cut that is not inside. Collective.
void FluidDomain::bring_links(const OpenSpace& space, OpenShares::Held& held) const {
  FaceField<FineGrid> bits;
  for (int d = 0; d < 3; ++d) {
    bits[d].reset(local, OpenSpace::kAllLinks);
    for_each(faces[d], [&](int i, int j, int k) { bits[d](i, j, k) = space.links[d](i, j, k); });
  }
  extend_faces(bits);
  for (int d = 0; d < 3; ++d) {
    held.links[d].reset(local, OpenSpace::kAllLinks);
    for_each(local, [&](int i, int j, int k) {
      const Int3 x{i, j, k};
      bool beyond = false;
      for (int e = 0; e < 3; ++e)
        beyond = beyond || (!grid.axis[e].periodic() && (x[e] < 0 || x[e] > grid.axis[e].n() - (d == e ? 0 : 1)));
      unsigned char& b = held.links[d](i, j, k);
      b = (unsigned char)(bits[d](i, j, k));
      if (beyond) b |= OpenSpace::kAllLinks;
    });
  }
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
