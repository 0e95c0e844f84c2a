// Viscous links beside the walls of bodies: where a stress of viscous_stress.h would touch a cut face, each pair of
// neighbouring faces of one component that no wall parts has instead
//   mu eps a A/h (u_g - u_f)        a: mean open share of the area between them; eps: of the open space
// the same force on both, of opposite sign. (The transposed gradients of tau are left out here: at a wall at rest they
// have no part in the force on it.) What a wall parts is friction (open_shares.h).
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
  /// diagonal += that of -add(), N s/m.
  void add_diagonal(const Property& mu, const CellField<FineGrid>& e, FaceField<FineGrid>& diagonal) const;

 private:
  struct Link {
    std::ptrdiff_t lower;  // memory index of the lower face
    double conductance;    // a A/h over the sum of theta of the cells around (m)
  };
  template <class F>
  void for_each_link(const Property& mu, const CellField<FineGrid>& e, F&& f) const;
  double aperture(int c, int d, std::ptrdiff_t lower, const Int3& x) const;

  const GridMeasures& measures_;
  std::array<std::array<std::vector<Link>, 3>, 3> links_;  // of component c, along d
};

}  // namespace twogrid
