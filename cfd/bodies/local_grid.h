// The rank's part of the grid and one cell around it, as the cutting sees it. Places are those of the domain: an image
// beyond a periodic side is asked of its original, so that what is found there hangs on the place alone, and has the
// same bits on all ranks that look at it.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "cfd/fluid_settings.h"
#include "cfd/grid/field.h"
#include "cfd/grid/layout.h"
#include "cfd/parallel/block_exchange.h"

namespace twogrid {

class LocalGrid {
 public:
  /// Collective. All must outlive this.
  LocalGrid(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings);
  LocalGrid(const LocalGrid&) = delete;

  /// Share of a cell's width within which a vertex counts as on a surface, and twice of which the sides' vertices are
  /// taken inwards: what lies in a side's plane is the side's, and what ends there, ends beyond.
  static constexpr double kOn = 1e-4, kInwards = 2 * kOn;

  const MPI_Comm comm;
  const FineGrid& grid;
  const FluidSettings& settings;
  const Box own, cells;              ///< cells: own and one around, not beyond sides that are not periodic
  const Box own_vertices, vertices;  ///< vertex (i,j,k): low corner of cell (i,j,k)
  const std::array<Box, 3> own_faces, faces;
  const std::array<bool, 3> solved;  ///< false: one cell deep and closed on both sides, nothing flows along it
  const BlockExchange vertex_halo, cell_halo;
  const FaceExchange face_halo;

  /// Index in the domain, of a cell, or of a vertex.
  int wrap(int d, int i) const { return periodic_[d] ? (i % n_[d] + n_[d]) % n_[d] : i; }
  /// Vertices and cells in an order of the whole domain.
  long long number(int i, int j, int k) const {
    return wrap(0, i) + (n_[0] + 1LL) * (wrap(1, j) + (n_[1] + 1LL) * wrap(2, k));
  }
  double node(int d, int i) const { return axis_[d].node[i - cells.lo[d]]; }
  double inner_node(int d, int i) const { return axis_[d].inner_node[i - cells.lo[d]]; }  ///< taken inwards at sides
  double width(int d, int i) const { return axis_[d].width[i - cells.lo[d]]; }            ///< of cell i
  double centre(int d, int i) const { return axis_[d].node[i - cells.lo[d]] + 0.5 * axis_[d].width[i - cells.lo[d]]; }
  double volume(const Int3& c) const { return width(0, c[0]) * width(1, c[1]) * width(2, c[2]); }
  /// Of the whole face.
  double area(int d, const Int3& c) const {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    return width(e, c[e]) * width(f, c[f]);
  }
  /// Centre of a face, taken inwards at sides.
  Vec3 face_centre(int d, const Int3& c) const;
  /// A face's own side of the domain, -1 inside.
  int side_of(int d, int i) const { return periodic_[d] ? -1 : i == 0 ? 2 * d : i == n_[d] ? 2 * d + 1 : -1; }
  bool inside(int d, int cell) const { return periodic_[d] || (cell >= 0 && cell < n_[d]); }
  /// Condition that holds at a face of a side: place in the settings' list.
  int condition(int side, const Int3& face) const;
  /// True where the side's condition lets fluid pass.
  bool passes(int side, const Int3& face) const;

 private:
  struct Coordinates {
    std::vector<double> node, inner_node, width;  // of cells.lo ... cells.hi
  };
  Int3 n_;
  std::array<bool, 3> periodic_;
  std::array<Coordinates, 3> axis_;
};

}  // namespace twogrid
