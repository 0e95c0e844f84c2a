#include "coupling/two_grid/cell_map.h"

#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

double CellMap::weight_of(int I, int J, int K, const CellField<FineGrid>* weight) const {
  double sum = 0;
  for_each(grid_.block(I, J, K), [&](int i, int j, int k) { sum += volume(i, j, k) * this->weight(i, j, k, weight); });
  return sum;
}

/// 1/W_n of own nodes, 0 where W_n is.
Array3<double> CellMap::inverse_weights(const CellField<FineGrid>* weight) const {
  Array3<double> inverse(own_);
  for_each(own_, [&](int I, int J, int K) { inverse(I, J, K) = weight_of(I, J, K, weight); });
  if (const OpenNodes* families = grid_.open_nodes()) families->total(slot_of(inverse));
  for (std::size_t m = 0; m < inverse.size(); ++m) {
    double& w = inverse.data()[m];
    w = w > 0 ? 1 / w : 0.0;
  }
  return inverse;
}

void CellMap::mean(const Cells& cells, const CellField<FineGrid>* weight, const Slot<FourNumbers>& node) const {
  if (cells == Cells{}) return;
  const Array3<double> inverse = inverse_weights(weight);
  std::vector<FourNumbers> sums(own_.count(), FourNumbers{});
  const Slot<FourNumbers> sum{own_, sums.data(), 1};
  for_each(own_, [&](int I, int J, int K) {
    for (int q = 0; q < 4; ++q) {
      if (!cells[q]) continue;
      for_each(grid_.block(I, J, K), [&](int i, int j, int k) {
        sums[sum.index(I, J, K)].at[q] += volume(i, j, k) * this->weight(i, j, k, weight) * (*cells[q])(i, j, k);
      });
    }
  });
  if (const OpenNodes* families = grid_.open_nodes()) families->total(sum);
  for_each(own_, [&](int I, int J, int K) {
    for (int q = 0; q < 4; ++q)
      if (cells[q])
        node.data[node.stride * node.index(I, J, K)].at[q] = sums[sum.index(I, J, K)].at[q] * inverse(I, J, K);
  });
}

void CellMap::spread(const Slot<FourWholeNumbers>& node, const std::array<FixedPoint, 2>& scale,
                     const CellField<FineGrid>* weight, const std::array<CellField<FineGrid>*, 4>& cells) const {
  const Array3<double> inverse = inverse_weights(weight);
  std::vector<FourWholeNumbers> sums(own_.count());
  const Slot<FourWholeNumbers> sum{own_, sums.data(), 1};
  for_each(own_, [&](int I, int J, int K) { sums[sum.index(I, J, K)] = node.data[node.stride * node.index(I, J, K)]; });
  if (const OpenNodes* families = grid_.open_nodes()) families->total(sum);
  for_each(own_, [&](int I, int J, int K) {
    for (int q = 0; q < 4; ++q) {
      if (!cells[q]) continue;
      const double density = scale[q < 3 ? 0 : 1].value(sums[sum.index(I, J, K)].at[q]) * inverse(I, J, K);
      for_each(grid_.block(I, J, K),
               [&](int i, int j, int k) { (*cells[q])(i, j, k) = density * this->weight(i, j, k, weight); });
    }
  });
}

}  // namespace twogrid
