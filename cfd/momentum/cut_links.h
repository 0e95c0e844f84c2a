// Viscous links beside the walls of bodies: where a stress of viscous_stress.h would touch a cut face, each pair of
// neighbouring faces of one component that no wall parts has instead
//   mu eps a A/h (c_g u_g - c_f u_f)        a: mean open share of the area between them; eps: of the open space
// with c u the velocities at their centres (OpenSpace::centre),
// the same force on both, of opposite sign. The transposed gradients of tau, which links don't have, sum up to nothing
// over a whole volume where mu and eps are uniform, but not over a part of its sides: faces with such links go without
// them on their other sides, too. Of the force on a wall at rest they are no part; what the fluid so loses all in all is
// counted. What a wall parts is friction (open_shares.h). Beside walls the sum of a face's links stands for the force on a
// volume that ends half way to the walls and neighbours; it is taken times OpenSpace::viscous, and what so exceeds the
// reaction on the neighbours comes from the wall.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "cfd/grid/field.h"
#include "cfd/grid/property.h"
#include "cfd/measures/grid_measures.h"

namespace twogrid {

class CutLinks {
 public:
  /// faces[d]: the rank's own faces. Open shares must be there; without links of their own there are none here. The
  /// measures must outlive this.
  CutLinks(const GridMeasures& measures, const std::array<Box, 3>& faces, const std::array<bool, 3>& solved);

  /// out += the links' forces on own faces, N; e: theta eps; u with halo and ghosts.
  void add(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
           FaceField<FineGrid>& out) const;
  /// Own faces that go without transposed gradients; left_out(): of each, what it would have of them, less what its links
  /// give it more than they take from its neighbours, N.
  const std::vector<std::ptrdiff_t>& faces(int c) const { return faces_[c]; }
  /// exceeding: the latter part alone, which is the wall's and has a torque about it.
  void left_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u,
                std::array<std::vector<double>, 3>& force, std::array<std::vector<double>, 3>& exceeding) const;
  /// diagonal += that of -add(), N s/m.
  void add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) const;

 private:
  /// Shares of the upper cells in the means over the four around an edge, in the component's direction and in the other.
  struct Around {
    double own, other;
  };
  struct Link {
    std::ptrdiff_t lower;  // memory index of the lower face
    double conductance;    // a A/h over the mean of theta of the cells around (m)
    Around around;         // not used along the component's own direction
    double centre[2];      // of the lower and the upper face
  };
  struct Transposed {
    int slot;           // of the face
    std::ptrdiff_t at;  // edge's or cell's memory index
    double factor;      // area, of the sign of the side, over the mean of theta around; on edges over the distance, too
    Vec3 inverse;       // of the cell's widths (1/m); not used on edges
    Around around;      // on edges
  };
  struct Steeper {
    int slot;  // of the face
    bool up;   // the link goes up from it
    Link link;
  };
  bool link_above(int c, int d, const Int3& x, Link& link) const;
  double conductance(const Link& link, bool along, std::ptrdiff_t sc, std::ptrdiff_t sd, const Property& mu,
                     const double* held, const double* theta) const;
  void list_transposed(int c, const Box& faces, const std::array<bool, 3>& solved);
  template <class F>
  void for_each_transposed(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u, F&& f) const;
  template <class F>
  void for_each_steeper(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u, F&& f) const;
  template <class F>
  void for_each_link(const Property& mu, const CellField<FineGrid>& e, F&& f) const;
  Around around(int c, int d, const Int3& edge) const;
  double aperture(int c, int d, std::ptrdiff_t lower, const Int3& x) const;

  const GridMeasures& measures_;
  std::array<std::array<std::vector<Link>, 3>, 3> links_;             // of component c, along d
  std::array<std::array<std::vector<Transposed>, 3>, 3> transposed_;  // the same
  std::array<std::array<std::vector<Steeper>, 3>, 3> steeper_;        // the same; conductance: times viscous less 1
  std::array<std::vector<std::ptrdiff_t>, 3> faces_;
};

}  // namespace twogrid
