// The pressure solver on grids of every awkward shape, on any number of ranks. Iteration counts are compared with those of
// the uniform cube.
#include <gtest/gtest.h>
#include <mpi.h>
#include <petscsys.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "cfd/parallel/ranks.h"
#include "cfd/pressure/pressure_solver.h"
#include "tests/unit/cfd/pressure_cases.h"

namespace twogrid_test {
namespace {

// Falsely passes without it: an operator whose periodic, boundary or rank faces are wrong but consistent between solver
// and multigrid converges happily, to the solution of another problem.
TEST(PressureSolver, RecoversAKnownSolution) {
  for (const Problem& p : problems())
    for (bool empty : {false, true}) {
      const Case c(p, empty);
      const auto r = c.solve(1e-12);
      EXPECT_LE(c.residual(r.phi), 2e-12) << p.name;
      // phi is of order 1; the error is the residual times the inverse's norm, some 1e4 at most here.
      EXPECT_LE(c.largest_error(r.phi), 1e-8) << p.name << (empty ? ", some ranks without cells" : "");
    }
}

// Falsely passes without it: a preconditioner that works on cubes alone, or whose bricks (aggregates never cross ranks)
// ruin it; the answer would still be right, after hundreds of iterations. Measured against the cube of as many cells,
// at least 8^3: below, a cube needs next to none.
TEST(PressureSolver, IterationsStayNearThoseOfTheCube) {
  std::map<int, int> reference;
  for (const Problem& p : problems()) {
    const int n = std::max(8, int(std::lround(std::cbrt(double(p.n[0]) * p.n[1] * p.n[2]))));
    if (!reference.count(n)) {
      Problem cube;
      cube.n = {n, n, n};
      reference[n] = Case(cube).solve(1e-6).iterations;
    }
    const int found = Case(p).solve(1e-6).iterations;
    if (rank_of(MPI_COMM_WORLD) == 0)
      std::printf("  %-60s %3d iterations (cube of %d: %d)\n", p.name.c_str(), found, n, reference[n]);
    EXPECT_LE(found, 2 * reference[n]) << p.name;
  }
}

// Falsely passes without it: a one-level preconditioner, good on the small grids of the tests above, whose iterations
// grow with the grid.
TEST(PressureSolver, IterationsDontGrowWithTheGrid) {
  int first = 0;
  for (int n : {16, 32, 64}) {
    Problem p;
    p.n = {n, n, n};
    const Case c(p);
    PressureSolver solver(MPI_COMM_WORLD, c.grid, c.layout, 1e-6);
    solver.set_operator(c.conductance, false);
    CellField<FineGrid> phi(c.own.grown(2));
    const double begin = MPI_Wtime();
    solver.set_operator(c.conductance, false);
    const int found = solver.solve(c.b, phi);
    const double cells = double(n) * n * n, time = MPI_Wtime() - begin;
    if (rank_of(MPI_COMM_WORLD) == 0)
      std::printf("  %d^3: %d iterations, %.3f us a cell\n", n, found, time / cells * 1e6);
    if (n == 16) first = found;
    EXPECT_LE(found, first + 2);
  }
}

// Falsely passes without it: halos exchanged too late or too little act as a weaker preconditioner or a slightly other
// operator that only the comparison with the answer of one rank shows.
TEST(PressureSolver, SameAnswerAsOneRank) {
  Problem p;
  p.n = {18, 11, 23};
  p.periodic = {true, false, false};
  p.coefficient = [](double x, double, double z) { return bubbles(100, x, z); };
  const Case c(p);
  const auto found = c.solve(1e-11);

  // One rank alone, on MPI_COMM_SELF, with one brick.
  Layout whole(c.grid, {std::vector<int>{0, p.n[0]}, {0, p.n[1]}, {0, p.n[2]}});
  PressureSolver alone(MPI_COMM_SELF, c.grid, whole, 1e-11);
  FaceField<FineGrid> g;
  for (int d = 0; d < 3; ++d) {
    g[d].reset(whole.faces(d, 0));
    for_each(g[d].box(), [&](int i, int j, int k) { g[d](i, j, k) = c.g(d, i, j, k); });
  }
  CellField<FineGrid> b(c.grid.cells()), phi(c.grid.cells());
  for_each(c.grid.cells(), [&](int i, int j, int k) { b(i, j, k) = c.applied(i, j, k); });
  alone.set_operator(g, false);
  alone.solve(b, phi);
  double difference = 0;
  for_each(c.own, [&](int i, int j, int k) {
    difference = std::max(difference, std::abs(phi(i, j, k) - found.phi(i, j, k)));
  });
  EXPECT_LE(c.max_over_ranks(difference), 1e-9);
}

// Falsely passes without it: a solver that forgets its first guess, or keeps coefficients of the call before.
TEST(PressureSolver, WarmStartAndNewCoefficients) {
  Problem p;
  p.n = {20, 7, 24};
  const Case first(p);
  p.coefficient = [](double x, double, double z) { return bubbles(30, x, z); };
  const Case second(p);
  PressureSolver solver(MPI_COMM_WORLD, first.grid, first.layout, 1e-10);
  CellField<FineGrid> phi(first.own.grown(2));
  solver.set_operator(first.conductance, false);
  solver.solve(first.b, phi);
  EXPECT_LE(first.largest_error(phi), 1e-7);
  EXPECT_EQ(solver.solve(first.b, phi), 0);
  solver.set_operator(second.conductance, false);
  phi.fill(0);  // the known solution is the same
  EXPECT_GT(solver.solve(second.b, phi), 3);
  EXPECT_LE(second.residual(phi), 1.01e-10);
  // An absolute tolerance above the first guess's residual: nothing to do.
  phi.fill(0);
  EXPECT_EQ(solver.solve(second.b, phi, 1e30), 0);
  // b = 0: zero, whatever the first guess.
  CellField<FineGrid> zero(first.own.grown(2));
  phi.fill(3);
  EXPECT_EQ(solver.solve(zero, phi), 0);
  for_each(first.own, [&](int i, int j, int k) { EXPECT_EQ(phi(i, j, k), 0); });
}

// Falsely passes without it: an option that is read but overruled by the constructor's value.
TEST(PressureSolver, ToleranceFromTheCommandLine) {
  Problem p;
  p.n = {12, 12, 12};
  const Case c(p);
  const int loose = c.solve(1e-2).iterations;
  for (const char* option : {"-fluid_pressure_rtol", "-fluid_pressure_ksp_rtol"}) {
    PetscOptionsSetValue(nullptr, option, "1e-12");
    const auto tight = c.solve(1e-2);
    PetscOptionsClearValue(nullptr, option);
    EXPECT_GT(tight.iterations, loose + 5) << option;
    EXPECT_LE(c.residual(tight.phi), 1.01e-12) << option;
  }
}

// Falsely passes without it: a smooth solution of large amplitude, where A phi rounds to far more than 1e-13 |b|; the
// residual of the recurrence goes down for ever while the true one stands, or the solver gives up with an error.
TEST(PressureSolver, StopsAtRoundOff) {
  Problem p;
  p.n = {40, 1, 40};
  p.outlet = Outlet::kNone;
  const Case c(p);
  CellField<FineGrid> b(c.own.grown(2)), phi(c.own.grown(2));
  for_each(c.own,
           [&](int i, int, int k) { b(i, 0, k) = std::cos(M_PI * (i + 0.5) / 40) * std::cos(M_PI * (k + 0.5) / 40); });
  PressureSolver solver(MPI_COMM_WORLD, c.grid, c.layout, 1e-16);
  solver.set_operator(c.conductance, true);
  solver.solve(b, phi);
  // Eigenvector of the uniform operator. Conductances: 40 x cells of 1/40 x 1 x 1/40 m.
  const double eigenvalue = -2 * 4 * std::pow(std::sin(M_PI / 80), 2) * c.g(0, 1, 0, 0);
  double error = 0;
  for_each(c.own,
           [&](int i, int j, int k) { error = std::max(error, std::abs(phi(i, j, k) - b(i, j, k) / eigenvalue)); });
  EXPECT_LE(c.max_over_ranks(error) * std::abs(eigenvalue), 1e-11);
}

// Falsely passes without it: a closed box in which more comes in than goes out is "solved" by silently dropping the
// difference: mass is lost without a word.
TEST(PressureSolver, RefusesWhatDoesNotBalance) {
  Problem p;
  p.n = {12, 6, 12};
  p.outlet = Outlet::kNone;
  const Case c(p);
  PressureSolver solver(MPI_COMM_WORLD, c.grid, c.layout, 1e-8);
  solver.set_operator(c.conductance, true);
  CellField<FineGrid> b = c.b, phi(c.own.grown(2));
  for_each(c.own, [&](int i, int j, int k) { b(i, j, k) += 1e-3; });
  EXPECT_THROW(solver.solve(b, phi), std::runtime_error);
  b = c.b;
  for_each(c.own, [&](int i, int j, int k) { b(i, j, k) += 1e-12; });
  EXPECT_NO_THROW(solver.solve(b, phi));
  EXPECT_LE(c.largest_error(phi), 1e-5);
  for_each(c.own, [&](int i, int j, int k) { b(i, j, k) = std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_THROW(solver.solve(b, phi), std::runtime_error);
}

}  // namespace
}  // namespace twogrid_test
