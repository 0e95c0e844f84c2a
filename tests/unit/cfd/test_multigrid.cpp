// The multigrid cycle as an operator: what conjugate gradients ask of it, and that it knows nothing of ranks.
#include <gtest/gtest.h>
#include <mpi.h>

#include <cmath>

#include "cfd/pressure/multigrid.h"
#include "tests/unit/cfd/pressure_cases.h"

namespace twogrid_test {
namespace {

/// Conductances of a box's faces in the layout the multigrid takes: halo of one where there are cells.
std::array<Array3<double>, 3> with_halo(const Case& c, const Box& own) {
  std::array<Array3<double>, 3> g;
  for (int d = 0; d < 3; ++d) {
    g[d].reset(own.empty() ? Box{} : own.grown(1));
    Box box = own;
    ++box.hi[d];
    if (own.lo[d] > 0 || c.problem.periodic[d]) --box.lo[d];
    if (!own.empty()) for_each(box, [&](int i, int j, int k) { g[d](i, j, k) = c.g(d, i, j, k); });
  }
  return g;
}

// Falsely passes without it: weights or coarse conductances that are wrong along brick borders only. They stay
// symmetric, and cost an iteration or two that no bound on iterations notices. Bricks of 8 cells or more are cut where
// one rank's pairs end too, so that the cycle is the same operator.
TEST(PressureMultigrid, SameCycleAsOnOneRank) {
  Problem p;
  p.n = {16, 16, 16};
  p.periodic = {true, true, false};
  p.coefficient = [](double x, double y, double z) { return 1 + 30 * x * x + 9 * y + bubbles(10, x, z); };
  const Case c(p);
  Multigrid<double> multigrid(MPI_COMM_WORLD, c.grid, c.layout);
  multigrid.set_operator(with_halo(c, c.own), false);
  Layout whole(c.grid, {std::vector<int>{0, 16}, {0, 16}, {0, 16}});
  Multigrid<double> alone(MPI_COMM_SELF, c.grid, whole);
  alone.set_operator(with_halo(c, c.grid.cells()), false);
  for_each(c.own, [&](int i, int j, int k) { multigrid.b()(i, j, k) = noise(i, j, k, 5); });
  for_each(c.grid.cells(), [&](int i, int j, int k) { alone.b()(i, j, k) = noise(i, j, k, 5); });
  multigrid.cycle();
  alone.cycle();
  double difference = 0, size = 0;
  for_each(c.own, [&](int i, int j, int k) {
    difference = std::max(difference, std::abs(multigrid.x()(i, j, k) - alone.x()(i, j, k)));
    size = std::max(size, std::abs(alone.x()(i, j, k)));
  });
  EXPECT_GT(alone.levels(), 2);
  EXPECT_LE(c.max_over_ranks(difference), 1e-12 * c.max_over_ranks(size));
}

// Falsely passes without it: conjugate gradients tolerate a preconditioner that is not quite symmetric and just take
// more iterations; restriction that is not the transpose of prolongation, or a smoother that isn't reversed, would hide
// there.
TEST(PressureMultigrid, IsSymmetricAndPositive) {
  for (const Problem& p : problems()) {
    const Case c(p);
    Multigrid<double> multigrid(MPI_COMM_WORLD, c.grid, c.layout);
    multigrid.set_operator(with_halo(c, c.own), c.singular);
    double mean[2] = {0, 0}, cells = double(p.n[0]) * p.n[1] * p.n[2];
    for_each(c.own, [&](int i, int j, int k) { mean[0] += noise(i, j, k, 2), mean[1] += noise(i, j, k, 3); });
    MPI_Allreduce(MPI_IN_PLACE, mean, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    // Cells without any open face have no equation.
    auto r = [&](int v, int i, int j, int k) {
      return c.coefficient(i, j, k) > 0 ? noise(i, j, k, 2 + v) - mean[v] / cells : 0;
    };
    double dot[4] = {0, 0, 0, 0};  // r_v B r_w
    for (int v : {0, 1}) {
      for_each(c.own, [&](int i, int j, int k) { multigrid.b()(i, j, k) = r(v, i, j, k); });
      multigrid.cycle();
      for_each(c.own, [&](int i, int j, int k) {
        for (int w : {0, 1}) dot[2 * v + w] += r(w, i, j, k) * multigrid.x()(i, j, k);
      });
    }
    MPI_Allreduce(MPI_IN_PLACE, dot, 4, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    if (p.n == Int3{1, 1, 1}) continue;  // nothing but its mean
    EXPECT_GT(dot[0], 0) << p.name;
    EXPECT_GT(dot[3], 0) << p.name;
    EXPECT_LE(std::abs(dot[1] - dot[2]), 1e-11 * std::sqrt(dot[0] * dot[3])) << p.name;
  }
}

}  // namespace
}  // namespace twogrid_test
