// Where the fluid is solved for: the rank's part of the grid with its sides, measures and exchanges. Made once.
#pragma once

#include <mpi.h>

#include <memory>

#include "cfd/bodies/cut_grid.h"
#include "cfd/boundary/boundaries.h"
#include "cfd/fluid/blowing.h"
#include "cfd/grid/field.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/grid_measures.h"
#include "cfd/parallel/block_exchange.h"

namespace twogrid {

struct FluidDomain {
  /// Collective. The settings must outlive this, and have passed their checks.
  FluidDomain(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings);
  FluidDomain(const FluidDomain&) = delete;

  const MPI_Comm comm;
  const int rank;
  const FineGrid grid;
  const Layout layout;
  const Box own;  ///< cells
  Boundaries boundaries;
  const Box local;                 ///< of all fields: own cells and halo
  const std::array<Box, 3> faces;  ///< own faces
  const std::array<bool, 3> solved;
  GridMeasures measures;
  const BlockExchange cell_halo;
  const FaceExchange face_halo;
  std::unique_ptr<Blowing> blowing;  ///< null where nothing blows

  /// Halo, prescribed faces and ghosts of a velocity; halo of a cell field. Collective.
  void fill(FaceField<FineGrid>& u) const;
  void fill(CellField<FineGrid>& c) const;
  /// Halo, and beyond the domain's sides the value of the cell at the side. Collective.
  void extend(CellField<FineGrid>& c) const;
  double volume() const;  ///< of the whole domain, its open part, m3
  double cells() const;   ///< of the whole domain, number
  /// What is said of the bodies in the grid; null without bodies.
  const CutReport* cut() const { return cut_.get(); }
  /// Velocities of sides and of what bodies blow, of now. True if the latter have changed: what is kept of walls'
  /// velocities must then be taken anew. Same on all ranks.
  bool update_velocities();
  /// True where the side or one of its patches is of the kind.
  bool has(int side, BoundaryKind kind) const;

 private:
  void make_open_shares();
  void add_up_friction(const OpenSpace& space, bool of_pieces, OpenShares::Held& held) const;
  void bring_blown_faces(const OpenSpace& space, OpenShares::Held& held) const;
  void bring_links(const OpenSpace& space, OpenShares::Held& held) const;
  void extend_faces(FaceField<FineGrid>& f) const;

  const FluidSettings& settings_;
  std::unique_ptr<const CutReport> cut_;
  OpenShares* shares_ = nullptr;  // those of measures
};

inline void reset(FaceField<FineGrid>& f, const Box& box) {
  for (auto& c : f) c.reset(box);
}

}  // namespace twogrid
