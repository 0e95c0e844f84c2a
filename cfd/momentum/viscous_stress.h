// Viscous stress in the momentum balance: div(eps tau), tau = mu (grad u + grad u^T - 2/3 div u I), on the staggered
// volumes (cfd/measures/grid_measures.h). With open shares eps is that of the whole cell, theta eps; beside a body's wall
// links stand in for the stress (cut_links.h), and its friction comes with its OpenSpace.
#pragma once

#include <array>
#include <initializer_list>
#include <memory>
#include <vector>

#include "cfd/grid/field.h"
#include "cfd/grid/property.h"
#include "cfd/measures/grid_measures.h"
#include "cfd/momentum/cut_links.h"

namespace twogrid {

class ViscousTerm {
 public:
  /// Arguments as ConvectionTerm's. The measures must outlive this.
  ViscousTerm(const GridMeasures& measures, const Box& own, const Box& local, const std::array<Box, 3>& faces,
              const std::array<bool, 3>& solved);

  /// out += integral of div(eps tau), tau = mu (grad u + grad u^T - 2/3 div u I), N.
  /// Where mu varies it is, on edges, the harmonic mean of the four cells by volume: the stress is then right at a jump
  /// across cells, as conductors in series are. eps and mu on the same box, halo and ghosts filled.
  void add(const Property& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  /// Beside bodies; null: nothing is cut.
  const CutLinks* cut() const { return cut_.get(); }
  CutLinks* cut() { return cut_.get(); }
  void renew_walls() {
    if (cut_) cut_->renew_walls();
  }
  /// Diagonal of -add(), approximately (for Jacobi), N s/m.
  void diagonal(const Property& mu, const CellField<FineGrid>& eps, FaceField<FineGrid>& diagonal) const;

 private:
  /// Values at one z. Beside bodies a row holds those of its part alone, and zero elsewhere.
  struct Slab {
    std::vector<double> value;
    std::vector<OpenRows::Part> part;  // of each row; empty without bodies
    double* data() { return value.data(); }
    const double* data() const { return value.data(); }
    void swap(Slab& other) { value.swap(other.value), part.swap(other.part); }
  };
  void list_rows(const OpenShares& open);
  OpenRows::Part take_part(const OpenRows& rows, int j, int k, std::initializer_list<Slab*> slabs) const;
  struct Uniform;
  struct Varying;
  void add_uniform(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  void add_varying(const CellField<FineGrid>& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                   FaceField<FineGrid>& out);
  void add_uniform_between_bodies(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u,
                                  FaceField<FineGrid>& out);
  void add_varying_between_bodies(const CellField<FineGrid>& mu, const CellField<FineGrid>& eps,
                                  const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  // whole: all rows have their whole length.
  template <bool whole, class Mu>
  void add_with(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  template <class Mu>
  void diagonal_with(const Mu& mu, const CellField<FineGrid>& eps, FaceField<FineGrid>& diagonal) const;
  double cut_share(int c, const Int3& x, std::ptrdiff_t m) const;
  template <bool whole, class Mu>
  void normal_stresses(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k);
  template <int t, bool whole, class Mu>
  void shear_stress(const Mu& mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k, Slab& out) const;
  template <int c, bool whole>
  void add_stress(int k, Array3<double>& out) const;

  const GridMeasures& measures_;
  Box own_, local_;
  std::array<Box, 3> faces_;
  std::array<bool, 3> solved_;
  std::array<AxisMeasure, 3> axis_;
  // Scratch of add(), slabs at one z: eps tau_cc in cells (of tau_zz also the slab below), eps tau_yz, tau_xz,
  // tau_xy on edges (of the first two also the slab above). Where a direction is left out there is no shear with it:
  // zero.
  std::array<Slab, 3> normal_, shear_;
  Slab normal_below_;
  std::array<Slab, 2> shear_above_;
  std::unique_ptr<CutLinks> cut_;
  // Of cut_: parts of rows of cells and edges with stresses, of the faces that feel them.
  OpenRows stressed_cells_;
  std::array<OpenRows, 3> stressed_edges_, stressed_faces_;
};

}  // namespace twogrid
