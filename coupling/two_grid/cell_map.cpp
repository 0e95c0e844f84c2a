#include "coupling/two_grid/cell_map.h"

namespace twogrid {

double CellMap::weight_of(int I, int J, int K, const CellField<FineGrid>* weight) const {
  double sum = 0;
  for_each(grid_.block(I, J, K), [&](int i, int j, int k) { sum += volume(i, j, k) * this->weight(i, j, k, weight); });
  return sum;
}

void CellMap::mean(const Cells& cells, const CellField<FineGrid>* weight, const Slot<FourNumbers>& node) const {
  if (cells == Cells{}) return;
  for_each(own_, [&](int I, int J, int K) {
    const double all = weight_of(I, J, K, weight), inverse = all > 0 ? 1 / all : 0.0;
    double* const out = node.data[node.stride * node.index(I, J, K)].at;
    for (int q = 0; q < 4; ++q) {
      if (!cells[q]) continue;
      double sum = 0;
      for_each(grid_.block(I, J, K), [&](int i, int j, int k) {
        sum += volume(i, j, k) * this->weight(i, j, k, weight) * (*cells[q])(i, j, k);
      });
      out[q] = sum * inverse;
    }
  });
}

void CellMap::spread(const Slot<FourWholeNumbers>& node, const std::array<FixedPoint, 2>& scale,
                     const CellField<FineGrid>* weight, const std::array<CellField<FineGrid>*, 4>& cells) const {
  for_each(own_, [&](int I, int J, int K) {
    const double all = weight_of(I, J, K, weight), inverse = all > 0 ? 1 / all : 0.0;
    const auto& sum = node.data[node.stride * node.index(I, J, K)].at;
    for (int q = 0; q < 4; ++q) {
      if (!cells[q]) continue;
      const double density = scale[q < 3 ? 0 : 1].value(sum[q]) * inverse;
      for_each(grid_.block(I, J, K),
               [&](int i, int j, int k) { (*cells[q])(i, j, k) = density * this->weight(i, j, k, weight); });
    }
  });
}

}  // namespace twogrid
