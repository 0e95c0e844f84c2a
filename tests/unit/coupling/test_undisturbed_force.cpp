// R = -(grad p - source + beta u)/eps on every face, with eps the mean over the face's volume, half of each of the two
// cells. Without this test a mean that gives the wider cell the narrower one's share would pass, since all other tests
// of formulation A have equal cells; so would a balance that leaves out the drag, and a halo that stays as it was.
#include <gtest/gtest.h>

#include <cmath>

#include "coupling/forces/undisturbed_force.h"
#include "tests/field_exchange.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

double void_fraction(const Vec3& x) {
  return 0.6 + 0.2 * std::sin(3 * x[0]) * std::cos(2 * kPi * x[1]) + 0.1 * std::sin(5 * x[2]);
}
double source(int d, const Vec3& x) {
  return 40 + 10 * d + 7 * std::sin(2 * kPi * x[1]) + 3 * x[0] * x[2];
}
double beta(int d, const Vec3& x) {
  return 11 + d + 2 * std::cos(2 * kPi * x[1]) + x[2];
}
double velocity(int d, const Vec3& x) {
  return 1.5 - d + x[0] + std::sin(2 * kPi * x[1]) - x[2];
}
double pressure_gradient(int d, const Vec3& x) {
  return -5 + d + 4 * x[0] + std::cos(2 * kPi * x[1]) + x[2] * x[2];
}

TEST(UndisturbedForce, IsWhatTheMomentumBalanceLeavesOnStretchedCells) {
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {false, true, false}, {1.3, 1, 1.15});
  FakeFluid fluid(MPI_COMM_WORLD, grid, make_layout(grid, ranks_of(MPI_COMM_WORLD), {1, 1, 1}), 1.2);
  fluid.set(fluid.mean_, velocity), fluid.set(fluid.gradient_, pressure_gradient);
  auto centre = [&](int i, int j, int k) {
    return Vec3{grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)};
  };
  for_each(fluid.eps_.box(), [&](int i, int j, int k) { fluid.eps_(i, j, k) = void_fraction(centre(i, j, k)); });
  FieldExchange exchange;
  for (int d = 0; d < 3; ++d)
    exchange.source[d].reset(fluid.own_faces_[d]), exchange.beta[d].reset(fluid.own_faces_[d]);
  fluid.set(exchange.source, source), fluid.set(exchange.beta, beta);

  FaceField<FineGrid> R;
  UndisturbedForce force(MPI_COMM_WORLD, fluid, R);
  for (int n = 0; n < 200; ++n) force.update(fluid, fluid.eps_, exchange, 900);  // to what its weight leads to

  double worst = 0;
  int halo = 0;
  for (int d = 0; d < 3; ++d)
    for_each(R[d].box(), [&](int i, int j, int k) {
      const Int3 c{i, j, k}, n = grid.n();
      Vec3 x = centre(i, j, k);
      x[d] = grid.axis[d].node(c[d]);
      for (int e : {0, 2})  // not beyond the sides, and not on them
        if (c[e] < (e == d ? 1 : 0) || c[e] >= n[e]) return;
      // The mean over the volume from centre to centre.
      Int3 below = c;
      --below[d];
      const double lo = grid.axis[d].centre(below[d]), hi = grid.axis[d].centre(c[d]);
      const double eps = ((x[d] - lo) * void_fraction(centre(below[0], below[1], below[2])) +
                          (hi - x[d]) * void_fraction(centre(c[0], c[1], c[2]))) /
                         (hi - lo);
      const double want = -(pressure_gradient(d, x) - source(d, x) + beta(d, x) * velocity(d, x)) / eps;
      worst = std::max(worst, std::abs(R[d](i, j, k) / want - 1));
      halo += !fluid.own_faces_[d].contains(i, j, k);
    });
  EXPECT_LT(worst, 1e-11);
  EXPECT_GT(halo, 100);
  if (rank_of(MPI_COMM_WORLD) == 0) std::printf("undisturbed force: largest relative error %.1e\n", worst);
}

}  // namespace
}  // namespace twogrid_test
