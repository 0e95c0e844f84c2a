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

  /// out += the links' forces on own faces, less what is left out of them, N; e: theta eps; u with halo and ghosts.
  void add(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  /// Own faces that go without transposed gradients.
  const std::vector<std::ptrdiff_t>& faces(int c) const { return faces_[c]; }
  /// Of each of them, what it would have of these gradients, less what its links give it more than they take from its
  /// neighbours, N: by add() or by this.
  void leave_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u);
  const std::array<std::vector<double>, 3>& left_out() const { return left_out_; }
  /// Of that the latter part alone, which is the wall's and has a torque about it.
  const std::array<std::vector<double>, 3>& exceeding() const { return exceeding_; }
  /// out += what walls that move along themselves give besides, N: links act on u - u_r (OpenSpace::Beside).
  void add_moving(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& out);
  /// Walls' velocities have changed (OpenShares::set_blowing).
  void renew_walls();
  /// The same in left_out() and exceeding(), after they are made.
  void leave_moving_out(const Property& mu, const CellField<FineGrid>& e);
  /// diagonal += that of -add(), N s/m.
  void add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal);

 private:
  /// Edges along one direction, or cells, where several of the forces need the same of what lies around.
  struct Edges {
    std::vector<std::ptrdiff_t> at;              // memory index
    std::vector<double> share_a, share_b;        // of the upper cells in the mean over the four around
    std::vector<double> in_links, in_gradients;  // of the step: mu eps. The second only where mu varies: else the same
  };
  struct Cells {
    std::vector<std::ptrdiff_t> at;
    std::array<std::vector<double>, 3> inverse;  // of the widths (1/m); 0: of a direction that is left out
    std::array<std::vector<double>, 3> stress;   // of the step: mu eps (du_c/dx_c - 2/3 div u)
  };
  struct Link {
    std::ptrdiff_t lower;  // memory index of the lower face
    int edge;              // of edges_ of the direction other than the component's and the link's; else not used
    double conductance;    // a A/h over the mean of theta of the cells around (m)
    double centre[2];      // of the lower and the upper face
    double drift = 0;      // of the upper less the lower face (m/s)
  };
  struct Transposed {
    int slot;       // of the face
    int place;      // of the edge or the cell
    double factor;  // area, of the sign of the side, over the mean of theta around; on edges over the distance, too
  };
  struct Steeper {
    int slot;  // of the face
    bool up;   // the link goes up from it
    Link link;
  };
  /// What a face has of u_r alone: of its own that its links' neighbours don't share, and on sides without links.
  struct Moved {
    int slot;
    double change;  // m/s
    Link link;
    bool exceeds;      // the wall's, as a steeper link's
    int steeper = -1;  // its place among them; -1: of a rigid motion
  };
  void list_moved(int c, const Box& faces);
  /// f(component, slot, force, exceeds), after set_means().
  template <class F>
  void for_each_moved(const Property& mu, const CellField<FineGrid>& e, F&& f) const;
  bool link_above(int c, int d, const Int3& x, Link& link);
  void list_transposed(int c, const Box& faces, const std::array<bool, 3>& solved);
  /// Places in edges_[t], at the low corner of cell x, and in cells_; made if need be.
  int place_of_edge(int t, const Int3& x);
  int place_of_cell(const Int3& x, const std::array<bool, 3>& solved);
  void set_means(const Property& mu, const CellField<FineGrid>& e);
  void set_stresses(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u);
  void sum_left_out(const Property& mu, const CellField<FineGrid>& e, const FaceField<FineGrid>& u);
  double conductance(int c, int d, const Link& link, const Property& mu, const double* held) const;
  double aperture(int c, int d, std::ptrdiff_t lower, const Int3& x) const;

  const GridMeasures& measures_;
  std::array<std::array<std::vector<Link>, 3>, 3> links_;             // of component c, along d
  std::array<std::array<std::vector<Transposed>, 3>, 3> transposed_;  // the same
  std::array<std::array<std::vector<Steeper>, 3>, 3> steeper_;        // the same; conductance: times viscous less 1
  std::array<Edges, 3> edges_;
  Cells cells_;
  std::array<std::vector<int>, 4> places_;  // of edges and cells, by memory index; while the lists are made
  std::array<std::vector<std::ptrdiff_t>, 3> faces_;
  std::array<std::vector<double>, 3> left_out_, exceeding_;
  bool moving_ = false;                                                // the rest is empty without it
  std::array<std::array<std::vector<Moved>, 3>, 3> moved_;             // of component c, along d
  std::array<std::array<std::vector<Transposed>, 3>, 3> moved_sides_;  // the same, on edges; factor: times the change
};

}  // namespace twogrid
