#include "cfd/bodies/wall_fit.h"

#include <cmath>

namespace twogrid {

std::vector<double> WallFit::of_first(double held) const {
  double matrix[kMost][kMost] = {}, value[kMost] = {1}, all = 0;
  for (const Point& p : points_) {
    all += p.weight;
    for (int a = 0; a < terms_; ++a)
      for (int b = 0; b <= a; ++b) matrix[a][b] += p.weight * p.term[a] * p.term[b];
  }
  for (int a = 0; a < terms_; ++a) matrix[a][a] += all * held * (a == 0 ? 1e-4 : 1);
  // Cholesky; value becomes the first row of the inverse.
  for (int a = 0; a < terms_; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int k = 0; k < b; ++k) matrix[a][b] -= matrix[a][k] * matrix[b][k];
      matrix[a][b] = a == b ? std::sqrt(matrix[a][a]) : matrix[a][b] / matrix[b][b];
    }
    for (int k = 0; k < a; ++k) value[a] -= matrix[a][k] * value[k];
    value[a] /= matrix[a][a];
  }
  for (int a = terms_ - 1; a >= 0; --a) {
    for (int k = a + 1; k < terms_; ++k) value[a] -= matrix[k][a] * value[k];
    value[a] /= matrix[a][a];
  }
  std::vector<double> weights;
  for (const Point& p : points_) {
    double sum = 0;
    for (int a = 0; a < terms_; ++a) sum += value[a] * p.term[a];
    weights.push_back(p.weight * sum);
  }
  return weights;
}

}  // namespace twogrid
