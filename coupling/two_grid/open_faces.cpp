#include "coupling/two_grid/open_faces.h"

#include <algorithm>
#include <map>

namespace twogrid {

OpenFaces::OpenFaces(const Array3<FaceState>& state, const Box& faces) : box_(faces) {
  const std::size_t n = faces.size(0);
  pattern_.reserve(std::size_t(faces.size(1)) * faces.size(2));
  std::map<std::vector<FaceState>, int> known;
  for (int k = faces.lo[2]; k < faces.hi[2]; ++k)
    for (int j = faces.lo[1]; j < faces.hi[1]; ++j) {
      const FaceState* first = &state.data()[state.index(faces.lo[0], j, k)];
      const std::vector<FaceState> row(first, first + n);
      const bool fixed = std::find(row.begin(), row.end(), FaceState::kFixed) != row.end();
      const auto [at, added] = known.emplace(row, fixed ? int(factor_.size()) : -1);
      if (added && fixed)
        for (FaceState s : row) factor_.push_back(s == FaceState::kSolved ? 1.0 : 0.0);
      pattern_.push_back(at->second);
    }
}

}  // namespace twogrid
