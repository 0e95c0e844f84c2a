#include "cfd/grid/grid.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace twogrid {

Axis::Axis(std::vector<double> nodes, bool periodic) : n_(int(nodes.size()) - 1), periodic_(periodic) {
  if (n_ < 1) throw std::invalid_argument("a grid direction needs at least 1 cell, found " + std::to_string(n_));
  for (int i = 0; i < n_; ++i)
    if (!(nodes[i + 1] > nodes[i]))
      throw std::invalid_argument("grid nodes must ascend, found " + std::to_string(nodes[i]) + " before " +
                                  std::to_string(nodes[i + 1]));
  const double length = nodes[n_] - nodes[0];
  node_.resize(n_ + 1 + 2 * kPad);
  for (int i = 0; i <= n_; ++i) node_[i + kPad] = nodes[i];
  for (int g = 1; g <= kPad; ++g) {
    // Periodic image or mirror image of the cell g places inside.
    const int from_lo = periodic ? ((-g % n_) + n_) % n_ : (g - 1) % n_;
    const int from_hi = periodic ? (g - 1) % n_ : n_ - 1 - (g - 1) % n_;
    node_[kPad - g] = node_[kPad - g + 1] - (nodes[from_lo + 1] - nodes[from_lo]);
    node_[kPad + n_ + g] = node_[kPad + n_ + g - 1] + (nodes[from_hi + 1] - nodes[from_hi]);
  }
  const double width = length / n_;
  inverse_width_ = 1 / width;
  for (int i = 0; i < n_; ++i)
    if (std::abs(nodes[i + 1] - nodes[i] - width) > 1e-9 * width) uniform_ = false;
}

int Axis::find(double x) const {
  if (x < lo()) return -1;
  if (x >= hi()) return n_;
  int i;
  if (uniform_) {
    i = std::min(int((x - lo()) * inverse_width_), n_ - 1);
  } else {
    i = int(std::upper_bound(node_.begin() + kPad, node_.begin() + kPad + n_ + 1, x) - node_.begin()) - kPad - 1;
  }
  // Rounding of the product above must not put x on the wrong side of a node.
  while (x < node(i)) --i;
  while (i + 1 < n_ && x >= node(i + 1)) ++i;
  return i;
}

std::vector<double> graded_nodes(double lo, double hi, int n, double ratio, bool symmetric) {
  if (n < 1) throw std::invalid_argument("a grid direction needs at least 1 cell, found " + std::to_string(n));
  if (!(hi > lo)) throw std::invalid_argument("a grid direction needs a length above 0");
  if (!(ratio > 0)) throw std::invalid_argument("stretch must be above 0, found " + std::to_string(ratio));
  std::vector<double> width(n), node(n + 1);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const int step = symmetric ? std::min(i, n - 1 - i) : i;
    sum += width[i] = std::pow(ratio, step);
  }
  node[0] = lo;
  double path = 0;
  for (int i = 0; i < n; ++i) {
    path += width[i];
    node[i + 1] = lo + (hi - lo) * (path / sum);
  }
  node[n] = hi;
  return node;
}

}  // namespace twogrid
