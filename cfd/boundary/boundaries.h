// Conditions on the sides of the fluid's domain: which faces are solved for, the values of the prescribed ones, and the
// ghost values beyond the sides.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/fluid_settings.h"
#include "cfd/grid/field.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

/// One patch, as the grid resolves it.
struct PatchArea {
  std::string name;
  int side;
  double area;  ///< m2, of the faces that belong to it
  double flux;  ///< m3/s, into the domain
};

class Boundaries {
 public:
  /// Collective. The settings have passed FluidSettings::check and check_flow.
  Boundaries(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings);

  const Array3<FaceState>& state(int d) const { return state_[d]; }
  /// True where some boundary face is a pressure outlet: p is then defined absolutely.
  bool open() const { return open_; }
  /// One cell deep and closed on both sides: that component is not solved for, and nothing varies along it.
  bool component_solved(int d) const { return solved_[d]; }
  /// Width of the fields' halo: that of Fluid, none in y or z where the component is not solved for.
  const Int3& halo() const { return halo_; }
  /// The rank's own cells and the halo: the box of all fields.
  const Box& local() const { return local_; }

  /// Closed faces become prescribed ones with u = 0, inside the domain too; of the sides' faces only the open part
  /// counts. The shares must outlive this. Collective.
  void close_faces(MPI_Comm comm, const OpenShares& open);
  /// Takes the inlet velocities that hold now (settings' velocity_now). Same on all ranks.
  void update();
  /// Sets prescribed normal velocities and fills ghosts of all components; the halo between ranks must be filled.
  /// homogeneous: the same with all prescribed values zero (for a correction of the velocity).
  void apply(FaceField<FineGrid>& u, bool homogeneous = false) const;
  /// Sets normal velocities of prescribed faces only.
  void apply_normal(FaceField<FineGrid>& u, bool homogeneous = false) const;
  /// Pressures of the outlets' faces: the prescribed one, lowered by rho u^2/2 where fluid comes in (still
  /// surroundings).
  void set_outlet_pressure(const FaceField<FineGrid>& u, double density);
  /// Ghost cells so that (p_ghost - p_inner)/(distance of centres) is the gradient at an outlet face of the pressure
  /// set last. Elsewhere p_ghost = p_inner.
  void apply_pressure(CellField<FineGrid>& p) const;
  /// The same for a correction phi: zero in an outlet's ghost, which stands for the face itself (half the distance).
  void apply_correction(CellField<FineGrid>& phi) const;
  /// eps on faces: sets prescribed inflow faces to 1 (an empty duct in front of them), times theta_f.
  void apply_face_eps(FaceField<FineGrid>& eps_f) const;
  /// Kind of the condition at a boundary face of a side (transverse indices from the cell index).
  BoundaryKind kind(int side, int i, int j, int k) const;

  /// Inlet patches and sides with their resolved area and present flux. Collective.
  std::vector<PatchArea> areas(MPI_Comm comm) const;
  /// Calls f(side, i, j, k) for the rank's own boundary faces of direction d; (i,j,k) is the face's index. Behind bodies
  /// only for those that fluid can have to do with, as far as rows along x end at them: nothing flows at the others.
  template <class F>
  void for_each_face(int side, F&& f) const;

 private:
  struct SideData {
    bool here = false;                                 // this rank's cells or halo reach beyond the side
    int d = 0, e = 0, f = 0;                           // normal, tangential directions (ascending)
    int face = 0;                                      // index of the boundary face in d
    int inner = 0, step = 0;                           // first inner cell; +1: inwards is up
    int lo_e = 0, n_e = 0, lo_f = 0, n_f = 0;          // tangential range with halo
    std::vector<int> condition;                        // of every boundary face in the range
    std::vector<unsigned char> outlet;                 // 1: a pressure outlet
    std::vector<double> outlet_pressure;               // Pa; empty on a side without outlets
    std::vector<double> profile;                       // factor on the inlet velocity
    std::vector<double> normal;                        // prescribed normal velocity
    std::array<std::vector<double>, 2> slope, offset;  // tangential ghost = slope * inner + offset, for e and f
    Box own;                                           // the rank's own boundary faces
    OpenRows open;  // with open shares: of these rows what is open, or has an open face behind it
    int at(int a, int b) const { return (a - lo_e) + n_e * (b - lo_f); }
  };
  /// Calls f(index in the side's lists, memory index of the inner cell in `like`) for all faces of a side in the range.
  template <class F>
  static void for_each_inner(const SideData& s, const Array3<double>& like, F&& f);
  /// Scales parabolic profiles so that the faces of a patch, not its drawn outline, carry the given mean. Collective.
  void normalise_parabolas(MPI_Comm comm, SideData& s, int side);
  void set_tangential(SideData& s, int side);
  double open_area(int d, int i, int j, int k) const;

  const FineGrid& grid_;
  const FluidSettings& settings_;
  Int3 halo_;
  Box local_;
  std::array<SideData, 6> side_;
  std::array<Array3<FaceState>, 3> state_;
  std::array<bool, 3> solved_{true, true, true};
  std::array<std::vector<Vec3>, 6> velocity_;  // of every condition, now
  bool open_ = false, known_ = false;
  const OpenShares* shares_ = nullptr;
};

template <class F>
void Boundaries::for_each_face(int side, F&& f) const {
  const SideData& s = side_[side];
  if (!s.here) return;
  for (int k = s.own.lo[2]; k < s.own.hi[2]; ++k)
    for (int j = s.own.lo[1]; j < s.own.hi[1]; ++j) {
      const OpenRows::Part p = shares_ ? s.open.bare(j, k) : OpenRows::Part{s.own.lo[0], s.own.hi[0]};
      for (int i = p.begin; i < p.end; ++i) f(side, i, j, k);
    }
}

}  // namespace twogrid
