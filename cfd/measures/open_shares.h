// Vessels and bodies inside the grid: which share of each face and of each cell is open to the fluid. Where nothing
// stands in the way there is no such object, and nothing is multiplied by it.
//
// With theta_f the mean of the two cells' theta by volume, as eps_f is that of eps, and the levels holding e = theta eps:
//   inertia share  i_f = mean of e                     what of the face's volume V_f is fluid
//   flux share     phi_f = (alpha/theta_f) i_f         F = phi u A, A the whole face's area
//   pressure       theta_f V_f (grad p + G): of the open part of the volume
//   edges, cells   eps of the open space where nothing is cut beside them, and no stress where something is: those links
//                  are momentum/cut_links.h's. Shares without links: eps times the smaller of the two links' open shares
// so that continuity, history and inertia keep their formulas. A closed face (alpha = 0) is a prescribed one with u = 0;
// its i_f and phi_f are eps of the open cells beside it, and never 0: what is divided by them stays finite.
#pragma once

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/measures/open_rows.h"

namespace twogrid {

class GridMeasures;

/// Friction between a face's momentum volume and a piece of a body's surface: mu eps conductance (u_w - u), N.
struct WallPiece {
  int body = 0;
  int component = 0;
  Int3 face{0, 0, 0};      ///< own
  double conductance = 0;  ///< wetted area over its distance (m)
  Vec3 point{0, 0, 0};     ///< on the surface (m)
  double velocity = 0;     ///< u_w (m/s), as the face's own velocity feels it: see OpenSpace::Beside
};
/// The surface inside one cell.
struct WallCell {
  int body = 0;        ///< of the larger part
  Int3 cell{0, 0, 0};  ///< own
  Vec3 area{0, 0, 0};  ///< sum of area times normal into the fluid (m2): what the open parts of its faces lack to close
  Vec3 point{0, 0, 0};  ///< on the surface (m)
};

/// A sliver, and what its fluid follows: the faces around it that are no slivers.
struct Sliver {
  int component = 0;
  Int3 face{0, 0, 0};  ///< own
  /// Shares of the velocities of the next faces of its component, low and high in x, y, z: together what it would have
  /// in shear along the wall.
  std::array<double, 6> share{0, 0, 0, 0, 0, 0};
  double drift = 0;     ///< and what the wall's own motion adds to that (m/s)
  double velocity = 0;  ///< the wall's (m/s)
};

/// The shares as they are given.
struct OpenSpace {
  FaceField<FineGrid> alpha;  ///< open share of the area of own faces, 0 to 1
  CellField<FineGrid> theta;  ///< open share of the volume of own cells; above 0 beside every face that is open at all
  /// K' of own faces (1/m2): friction -mu K' i_f u per volume, of walls that no side of the domain stands for. Of size 0
  /// where there is none.
  FaceField<FineGrid> friction;
  /// Bits of own faces: 1 << (2 d + high): viscous stress passes between this face and the next one below or above in d,
  /// of the same component; nothing of a wall stands between them. kSliver: open, but its centre lies in the solid: it
  /// flows by pressure and wall friction alone. Of size 0: all open faces are linked, those beside closed ones not.
  std::array<Array3<unsigned char>, 3> links;
  static constexpr unsigned char kAllLinks = 63, kSliver = 64;
  /// Velocity at the centre of own faces over that of their open part, 0 to 1: beside a wall that holds the fluid, the
  /// distances of the two from it are so. Of size 0: 1.
  FaceField<FineGrid> centre;
  /// Factor of the viscous forces on own faces beside walls, of which K' has it already: the open volume over the one
  /// that gives the force per volume exactly for a parabola, too. Of size 0: 1.
  FaceField<FineGrid> viscous;
  std::vector<Sliver> slivers;
  std::vector<WallPiece> pieces;  ///< friction from which K' is made: K' theta_f V_f = sum of conductances
  std::vector<WallCell> surface;
  std::vector<std::vector<Vec3>> outlines;  ///< of the surface in these cells (m), where they are asked for
  /// Near walls that move along themselves (solid_shape.h). Each face takes the nearest wall's motion as that of a rigid
  /// body, u_r, which has no strain: friction, links and what slivers follow act on u - u_r, for which the wall is at rest.
  struct Beside {
    int component = 0;
    Int3 face{0, 0, 0};   ///< own
    Vec3 slope{0, 0, 0};  ///< of its component of u_r along x, y, z (1/s)
  };
  std::vector<Beside> beside;
  /// u_r of own faces where their velocities are, and u_r at their centres less `centre` times that. Of size 0: 0.
  FaceField<FineGrid> wall_velocity, drift;

  /// Where bodies blow (Body::blow): what a velocity U of 1 m/s adds to velocities of walls, whose normal is that of the
  /// nearest point that blows.
  struct Blown {
    int body, place;         ///< in bodies; in pieces or slivers
    double velocity, drift;  ///< shares of U; drift: of slivers
  };
  std::vector<Blown> blown_pieces, blown_slivers;
  struct BlownFace {
    int body, component;
    Int3 face;               ///< own
    double velocity, drift;  ///< shares of U in wall_velocity and drift
  };
  std::vector<BlownFace> blown_faces;
  /// The surface that blows in a cell.
  struct BlownCell {
    int body;
    Int3 cell;         ///< own
    double size;       ///< its area (m2)
    Vec3 area, along;  ///< area times normal into the fluid (m2); its own motion along itself (m/s)
  };
  std::vector<BlownCell> blown_cells;
};

/// Fills the shares of the rank's own faces and cells, in which on entry all is open and there is no friction. Called
/// once, on all ranks.
using OpenSpaceModel = std::function<void(const FineGrid&, OpenSpace&)>;

class OpenShares {
 public:
  /// What a rank holds: fields on own cells and halo, halo and ghosts filled.
  struct Held {
    FaceField<FineGrid> alpha, theta_f;  // theta_f: the mean of theta
    CellField<FineGrid> theta;
    FaceField<FineGrid> friction;                    // of size 0 where there is none
    std::array<Array3<unsigned char>, 3> links;      // as OpenSpace's; beyond the domain's sides all; of size 0: none
    std::array<std::vector<std::ptrdiff_t>, 3> own;  // memory indices of own faces that are closed or slivers
    FaceField<FineGrid> centre, viscous;             // of size 0: 1
    std::vector<Sliver> slivers;
    std::vector<WallPiece> pieces;
    std::vector<WallCell> surface;
    std::vector<std::vector<Vec3>> outlines;
    std::vector<OpenSpace::Beside> beside;
    FaceField<FineGrid> wall_velocity, drift;  // of size 0: 0
    std::vector<OpenSpace::Blown> blown_pieces, blown_slivers;
    FaceField<FineGrid> blown_body, blown_velocity, blown_drift;  // OpenSpace::blown_faces; of size 0: none
    double volume = 0;                                            // of the whole domain's open part (m3)
  };
  /// own, faces: the rank's own cells and faces.
  OpenShares(const GridMeasures& measures, const Box& local, const Box& own, const std::array<Box, 3>& faces,
             const std::array<bool, 3>& solved, Held held);

  /// Open share of cells; own cells, halo, ghosts.
  const CellField<FineGrid>& theta() const { return theta_; }
  /// theta_f of faces that are open at all, 0 of closed ones.
  const FaceField<FineGrid>& theta_f() const { return theta_f_; }
  /// alpha/theta_f; of closed faces 0, or -1 where no open cell is beside them.
  const FaceField<FineGrid>& ratio() const { return ratio_; }
  /// alpha of a face by memory index.
  double alpha(int d, std::ptrdiff_t m) const { return ratio_[d].data()[m] * theta_f_[d].data()[m]; }
  /// Factor from the mean of e over an edge's four cells to eps times the edge's open share; edge along t at the low
  /// corner of the cell. With links: to eps, or 0 where one of its faces is cut.
  const CellField<FineGrid>& edge(int t) const { return edge_[t]; }
  /// With links: factor from a cell's e to eps, or 0 where one of its faces is cut.
  const CellField<FineGrid>& cell() const { return cell_; }
  bool has_links() const { return links_[0].size() > 0; }
  /// True if viscous stress passes from the face of component c to the next one above in d.
  bool linked(int c, int d, std::ptrdiff_t lower) const {
    return (links_[c].data()[lower] >> (2 * d + 1) & 1) && (links_[c].data()[lower + theta_.stride(d)] >> (2 * d) & 1);
  }
  bool sliver(int c, std::ptrdiff_t m) const { return links_[c].data()[m] & OpenSpace::kSliver; }
  /// Memory indices of own faces that take no part in convection: slivers, and closed ones.
  const std::vector<std::ptrdiff_t>& without_convection(int c) const { return without_convection_[c]; }
  /// OpenSpace's, by memory index. Looked up in a list.
  double centre(int c, std::ptrdiff_t m) const { return looked_up(centre_[c], m); }
  double viscous(int c, std::ptrdiff_t m) const { return looked_up(viscous_[c], m); }
  double wall_velocity(int c, std::ptrdiff_t m) const { return looked_up(wall_velocity_[c], m, 0); }
  double drift(int c, std::ptrdiff_t m) const { return looked_up(drift_[c], m, 0); }
  const std::vector<OpenSpace::Beside>& beside() const { return beside_; }
  const std::vector<Sliver>& slivers() const { return slivers_; }
  const std::vector<WallPiece>& pieces() const { return pieces_; }
  const std::vector<WallCell>& surface() const { return surface_; }
  /// A closed line around each of them; empty unless asked for.
  const std::vector<std::vector<Vec3>>& outlines() const { return outlines_; }
  /// What walls that blow add to velocities of pieces, slivers and faces: that of each body, m/s. Whoever keeps some of
  /// these velocities must take them anew. At first all blow with 1 m/s.
  void set_blowing(const std::vector<double>& velocity);
  bool has_friction() const { return friction_[0].size() > 0; }
  /// K' of own faces.
  const FaceField<FineGrid>& friction() const { return friction_; }
  /// Memory indices of closed faces, halo included.
  const std::vector<std::ptrdiff_t>& closed(int d) const { return closed_[d]; }
  /// Zero on all of them.
  void close(int d, double* face) const;
  double volume() const { return volume_; }
  /// Rows of own cells and own faces as far as they are open, and of own faces that are open or have an open neighbour
  /// of their component: momentum is carried no further.
  const OpenRows& cells() const { return cells_; }
  const OpenRows& faces(int d) const { return faces_[d]; }
  const OpenRows& surroundings(int d) const { return surroundings_[d]; }

  /// phi_f from i_f, which is the mean of e; both get what closed faces have.
  void flux_share(FaceField<FineGrid>& i_f, FaceField<FineGrid>& phi_f) const;

 private:
  using Exceptions =
      std::vector<std::pair<std::ptrdiff_t, double>>;  // where a number is not the usual, by memory index
  static Exceptions exceptions(const Array3<double>& field, double usual = 1);
  static double looked_up(const Exceptions& list, std::ptrdiff_t m, double usual = 1);
  void list_blown(Held& held);
  double theta_around(const GridMeasures& measures, int t, const Int3& x) const;
  void set_edges(const GridMeasures& measures, const Box& local, const FaceField<FineGrid>& alpha);
  void set_uncut(const GridMeasures& measures, const Box& local, const std::array<bool, 3>& solved,
                 const FaceField<FineGrid>& alpha);

  CellField<FineGrid> theta_;
  FaceField<FineGrid> theta_f_, ratio_, friction_;
  std::array<CellField<FineGrid>, 3> edge_;
  CellField<FineGrid> cell_;
  std::array<Array3<unsigned char>, 3> links_;
  std::array<std::vector<std::ptrdiff_t>, 3> closed_, without_convection_;
  struct Run {
    std::ptrdiff_t first, length;
  };
  std::array<std::vector<Run>, 3> closed_runs_;  // the same faces
  using OpenBeside = std::vector<std::pair<std::ptrdiff_t, double>>;
  std::array<OpenBeside, 3> open_beside_;  // those of them with an open cell beside, and 1/theta_f
  std::array<Exceptions, 3> centre_, viscous_, wall_velocity_, drift_;
  std::vector<OpenSpace::Beside> beside_;
  /// A number that walls which blow have a part in.
  struct BlownNumber {
    double* number;
    int body;
    double at_rest, share;  // without it; of the body's velocity
  };
  std::vector<BlownNumber> blown_;
  std::vector<Sliver> slivers_;
  std::vector<WallPiece> pieces_;
  std::vector<WallCell> surface_;
  std::vector<std::vector<Vec3>> outlines_;
  double volume_;
  OpenRows cells_;
  std::array<OpenRows, 3> faces_, surroundings_;
};

}  // namespace twogrid
