// Closes what is open on paper only: slivers of faces, cells that nothing leads into, pockets. Until nothing changes.
#pragma once

#include "cfd/bodies/fluid_vertices.h"

namespace twogrid {

class CleanUp {
 public:
  static constexpr double kLeastShare = 1e-3;  ///< of a face's area; and thickness of a cell's open part

  /// alpha, theta: on the faces and cells of LocalGrid; own ones count, the others are brought. Collective.
  CleanUp(const LocalGrid& grid, FaceField<FineGrid>& alpha, CellField<FineGrid>& theta)
      : grid_(grid), alpha_(alpha), theta_(theta) {}

  void close_slivers();
  /// Parts of the open cells that reach no inlet, outlet or cell beside `held` vertices; in a closed domain without
  /// such vertices all but the largest. Returns their volume (m3).
  double close_pockets(const std::vector<Int3>& held);

 private:
  enum { kInlet, kOutlet, kHeld, kMarks };  // of a part
  bool leads_on(int d, const Int3& face) const;
  void refuse_dead_ends(const ConnectedParts& parts, const std::vector<int>& mark, const std::vector<double>& volume,
                        const std::vector<bool>& stays) const;

  const LocalGrid& grid_;
  FaceField<FineGrid>& alpha_;
  CellField<FineGrid>& theta_;
};

}  // namespace twogrid
