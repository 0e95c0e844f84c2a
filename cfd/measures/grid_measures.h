// Widths, areas and volumes of the rank's part of the staggered grid, halo included, and means from cells to faces. The
// volume of face f normal to c reaches from the centre of cell f-1 to that of cell f; at a pressure outlet only the half
// inside the domain counts. Rows of them: row_measures.h. Areas and volumes are the grid's; what of them is open, where
// bodies stand in the grid: open() (open_shares.h).
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

/// One-dimensional measures of an axis, by index, including the halo.
struct AxisMeasure {
  int lo = 0;
  std::vector<double> width_, face_width_, half_below_, half_above_;
  std::vector<double> inverse_width_, inverse_face_width_;        // 1/m
  std::vector<double> above_share_;                               // of cell i in the mean of cells i-1 and i
  double width(int i) const { return width_[i - lo]; }            ///< of cell i, m
  double face_width(int i) const { return face_width_[i - lo]; }  ///< between centres of cells i-1 and i, m
  double half_below(int i) const { return half_below_[i - lo]; }  ///< part of face i's volume in cell i-1 (0 outside)
  double half_above(int i) const { return half_above_[i - lo]; }  ///< part of face i's volume in cell i (0 outside)
};

class GridMeasures {
 public:
  /// own: the rank's cells; local: own cells and halo.
  GridMeasures(const FineGrid& grid, const Box& own, const Box& local);

  const AxisMeasure& axis(int d) const { return axis_[d]; }
  /// Open shares of faces and cells; null: all is open.
  const OpenShares* open() const { return open_.get(); }
  void set_open(std::unique_ptr<const OpenShares> open) { open_ = std::move(open); }
  /// Parts of the rows of own cells that are open, of own faces, of own faces and those beside them; null: whole rows.
  const OpenRows* open_cells() const { return open_ ? &open_->cells() : nullptr; }
  const OpenRows* open_faces(int d) const { return open_ ? &open_->faces(d) : nullptr; }
  const OpenRows* open_surroundings(int d) const { return open_ ? &open_->surroundings(d) : nullptr; }
  /// Area of face (i,j,k) normal to d, m2; volume of cell (i,j,k), m3.
  double area(int d, int i, int j, int k) const {
    const Int3 q{i, j, k};
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    return axis_[e].width(q[e]) * axis_[f].width(q[f]);
  }
  double cell_volume(int i, int j, int k) const { return axis_[0].width(i) * axis_[1].width(j) * axis_[2].width(k); }
  /// Volume of face (i,j,k) normal to c, m3.
  double volume(int c, int i, int j, int k) const {
    const Int3 q{i, j, k};
    const int e = (c + 1) % 3, f = (c + 2) % 3;
    return (axis_[c].half_below(q[c]) + axis_[c].half_above(q[c])) * axis_[e].width(q[e]) * axis_[f].width(q[f]);
  }
  /// The open parts of a face's area, of a cell's volume's share, and of a face's volume (0 of closed faces).
  double open_area(int d, int i, int j, int k) const {
    const double whole = area(d, i, j, k);
    return open_ ? whole * open_->alpha(d, open_->theta().index(i, j, k)) : whole;
  }
  double open_share(int i, int j, int k) const { return open_ ? open_->theta()(i, j, k) : 1.0; }
  double open_volume(int c, int i, int j, int k) const {
    const double whole = volume(c, i, j, k);
    return open_ ? whole * open_->theta_f()[c](i, j, k) : whole;
  }
  /// Share of the upper cell in what is open of a face's volume.
  double open_share_above(int c, int i, int j, int k) const {
    const double above = axis_[c].above_share_[Int3{i, j, k}[c] - axis_[c].lo];
    if (!open_) return above;
    const CellField<FineGrid>& theta = open_->theta();
    const std::ptrdiff_t m = theta.index(i, j, k);
    const double high = above * theta.data()[m], low = (1 - above) * theta.data()[m - theta.stride(c)];
    return high + low > 0 ? high / (high + low) : above;
  }
  /// eps on faces: volume-weighted arithmetic mean of the two cells, so that sums over cells and faces agree.
  void face_mean(const CellField<FineGrid>& eps, FaceField<FineGrid>& eps_f) const;
  /// The same for one own face of direction c.
  double face_mean(const CellField<FineGrid>& eps, int c, int i, int j, int k) const {
    const std::ptrdiff_t m = eps.index(i, j, k);
    const double below = eps.data()[m - eps.stride(c)];
    return below + axis_[c].above_share_[Int3{i, j, k}[c] - axis_[c].lo] * (eps.data()[m] - below);
  }

 private:
  bool empty_;
  Box local_;
  std::array<AxisMeasure, 3> axis_;
  std::unique_ptr<const OpenShares> open_;
};

}  // namespace twogrid
