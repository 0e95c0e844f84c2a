// The lid-driven cavity. Without it, a wrong convective term of a recirculating flow, or wrong walls and corners, would
// pass: the analytic flows have no net convection near walls. Reference: U. Ghia, K. N. Ghia, C. T. Shin, J. Comput.
// Phys. 48 (1982) 387-411, tables I and II (129 x 129 multigrid).
#include <gtest/gtest.h>

#include <algorithm>

#include "cfd_box.h"

using namespace twogrid;

namespace {

constexpr int kPoints = 15;
const double kY[kPoints] = {0.9766, 0.9688, 0.9609, 0.9531, 0.8516, 0.7344, 0.6172, 0.5000,
                            0.4531, 0.2813, 0.1719, 0.1016, 0.0703, 0.0625, 0.0547};
const double kX[kPoints] = {0.9688, 0.9609, 0.9531, 0.9453, 0.9063, 0.8594, 0.8047, 0.5000,
                            0.2344, 0.2266, 0.1563, 0.0938, 0.0781, 0.0703, 0.0625};
const double kU100[kPoints] = {0.84123,  0.78871,  0.73722,  0.68717,  0.23151,  0.00332,  -0.13641, -0.20581,
                               -0.21090, -0.15662, -0.10150, -0.06434, -0.04775, -0.04192, -0.03717};
const double kV100[kPoints] = {-0.05906, -0.07391, -0.08864, -0.10313, -0.16914, -0.22445, -0.24533, 0.05454,
                               0.17527,  0.17507,  0.16077,  0.12317,  0.10890,  0.10091,  0.09233};
const double kU1000[kPoints] = {0.65928,  0.57492,  0.51117,  0.46604,  0.33304,  0.18719,  0.05702, -0.06080,
                                -0.10648, -0.27805, -0.38289, -0.29730, -0.22220, -0.20196, -0.18109};
const double kV1000[kPoints] = {-0.21388, -0.27669, -0.33714, -0.39188, -0.51550, -0.42665, -0.31966, 0.02526,
                                0.32235,  0.33075,  0.37095,  0.32627,  0.30353,  0.29012,  0.27485};

/// A steady cavity: positions and values of a velocity component on a tensor grid, walls included.
struct Component {
  std::vector<double> x, y, value;
  double& v(int i, int j) { return value[i + x.size() * j]; }
  double v(int i, int j) const { return value[i + x.size() * j]; }
};

/// Weights of the cubic through four neighbouring positions.
int cubic(const std::vector<double>& x, double at, double w[4]) {
  int first = int(std::upper_bound(x.begin(), x.end(), at) - x.begin()) - 2;
  first = std::min(std::max(first, 0), int(x.size()) - 4);
  for (int a = 0; a < 4; ++a) {
    w[a] = 1;
    for (int b = 0; b < 4; ++b)
      if (a != b) w[a] *= (at - x[first + b]) / (x[first + a] - x[first + b]);
  }
  return first;
}

double interpolate(const Component& c, double x, double y) {
  double wx[4], wy[4], sum = 0;
  const int i = cubic(c.x, x, wx), j = cubic(c.y, y, wy);
  for (int b = 0; b < 4; ++b)
    for (int a = 0; a < 4; ++a) sum += wx[a] * wy[b] * c.v(i + a, j + b);
  return sum;
}

struct Cavity {
  Component u, v;
};

/// Runs on n x n cells for a time T from the given solution (null: at rest).
Cavity run(double reynolds, int n, double stretch, double T, const Cavity* from, Convection scheme) {
  FluidSettings s;
  s.density = 1;
  s.viscosity = 1 / reynolds;
  s.convection = scheme;
  s.implicit_viscosity = Choice::kOn;
  s.pressure_rtol = 1e-5;
  for (int side : {kXlo, kXhi, kYlo}) s.side[side] = {condition(BoundaryKind::kNoSlip)};
  s.side[kYhi] = {condition(BoundaryKind::kNoSlip, {1, 0, 0})};
  s.side[kZlo] = s.side[kZhi] = {condition(BoundaryKind::kSlip)};
  const auto nodes = graded_nodes(0, 1, n, std::pow(stretch, 16.0 / n), true);
  const int steps = int(std::ceil(T / (0.5 / n)));
  s.dt = T / steps;
  CfdBox box({nodes, nodes, uniform(0, 1.0 / n, 1)}, {false, false, false}, s);
  if (from) {
    auto u = box.face_field();
    auto set = [&](int d, const Component& c) {
      for_each(box.faces(d), [&](int i, int j, int k) {
        const Vec3 x = box.face(d, i, j, k);
        u[d](i, j, k) = interpolate(c, x[0], x[1]);
      });
    };
    set(0, from->u), set(1, from->v);
    CellField<FineGrid> p(box.eps_begin.box());
    box.fluid->set_state(0, u, p, box.eps_begin, 0, u, box.eps_begin);
  }
  for (int k = 0; k < steps; ++k) box.step(s.dt);
  Cavity result;
  const auto u = box.gathered(0, box.fluid->velocity()[0]), v = box.gathered(1, box.fluid->velocity()[1]);
  std::vector<double> walls{0};
  for (int i = 0; i < n; ++i) walls.push_back(box.grid.axis[0].centre(i));
  walls.push_back(1);
  result.u = {nodes, walls, std::vector<double>((n + 1) * (n + 2), 0.0)};
  result.v = {walls, nodes, std::vector<double>((n + 1) * (n + 2), 0.0)};
  for (int i = 0; i <= n; ++i) result.u.v(i, n + 1) = 1;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i <= n; ++i) result.u.v(i, j + 1) = u[box.at(i, j, 0)], result.v.v(j + 1, i) = v[box.at(j, i, 0)];
  return result;
}

/// u at Ghia's points on the vertical centreline, v at those on the horizontal one.
std::vector<double> centrelines(const Cavity& c) {
  std::vector<double> all;
  for (double y : kY) all.push_back(interpolate(c.u, 0.5, y));
  for (double x : kX) all.push_back(interpolate(c.v, x, 0.5));
  return all;
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / a.size());
}

double worst(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

void compare(double reynolds, const std::vector<int>& cells, const std::vector<double>& times, double stretch,
             Convection scheme, const double* u, const double* v) {
  std::vector<double> ghia(u, u + kPoints);
  ghia.insert(ghia.end(), v, v + kPoints);
  std::vector<std::vector<double>> line;
  Cavity state;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    state = run(reynolds, cells[i], stretch, times[i], i ? &state : nullptr, scheme);
    line.push_back(centrelines(state));
  }
  const std::size_t f = cells.size() - 1;
  // Grids refined by two: the error is extrapolated to zero width with the order two, and the order is measured.
  std::vector<double> extrapolated(line[f].size());
  for (std::size_t q = 0; q < extrapolated.size(); ++q)
    extrapolated[q] = line[f][q] + (line[f][q] - line[f - 1][q]) / 3;
  const double order = std::log2(rms(line[f - 2], line[f - 1]) / rms(line[f - 1], line[f]));
  report(
      "cavity Re %g, %s, %d %d %d cells: largest difference to Ghia et al. %.4f %.4f %.4f, extrapolated %.4f; order "
      "%.2f\n",
      reynolds, scheme == Convection::kCentral ? "central" : "van Leer", cells[f - 2], cells[f - 1], cells[f],
      worst(line[f - 2], ghia), worst(line[f - 1], ghia), worst(line[f], ghia), worst(extrapolated, ghia), order);
  EXPECT_LT(worst(extrapolated, ghia), 0.01);  // of the lid's speed
  EXPECT_GT(order, 1.8);
}

}  // namespace

TEST(Cavity, Reynolds100) {
  compare(100, {10, 20, 40}, {15, 8, 6}, 1.0, Convection::kCentral, kU100, kV100);
  compare(100, {10, 20, 40}, {15, 8, 6}, 1.0, Convection::kVanLeer, kU100, kV100);
}

TEST(Cavity, Reynolds1000) {
  compare(1000, {16, 32, 64}, {30, 15, 10}, 1.15, Convection::kCentral, kU1000, kV1000);
}
