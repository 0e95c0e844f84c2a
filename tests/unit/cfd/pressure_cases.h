// For tests of the pressure solver: grids of every awkward shape, cut for any number of ranks, and a known answer on each.
// The right-hand side is A phi for a phi known beforehand, summed here face by face from the definition in
// pressure_solver.h, not with the solver's own operator.
#pragma once

#include <gtest/gtest.h>
#include <mpi.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/ranks.h"
#include "cfd/pressure/pressure_solver.h"

namespace twogrid_test {

using namespace twogrid;

/// A number in [0,1) that depends on the indices alone (splitmix64's finaliser), the same on any number of ranks.
inline double noise(int i, int j, int k, int seed) {
  std::uint64_t h = std::uint64_t(i) + 1000ull * j + 1000000ull * k + 1000000000ull * seed;
  h += 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  return double((h ^ (h >> 31)) >> 11) / 9007199254740992.0;
}

enum class Outlet { kTop, kAll, kNone };

struct Problem {
  std::string name;
  Int3 n;
  Vec3 length{1, 1, 1};
  Vec3 stretch{1, 1, 1};
  std::array<bool, 3> periodic{false, false, false};
  Outlet outlet = Outlet::kTop;
  std::function<double(double, double, double)> coefficient = [](double, double, double) { return 1.0; };
};

/// A grid in bricks, conductances, a known phi and its right-hand side, on this rank.
struct Case {
  Problem problem;
  FineGrid grid;
  Layout layout;
  Box own;
  FaceField<FineGrid> conductance;
  CellField<FineGrid> phi, b;
  bool singular;

  /// The brick counts halve the direction with most cells again and again. empty: the last brick of z is left empty.
  Case(const Problem& p, bool empty = false) : problem(p), singular(p.outlet == Outlet::kNone) {
    for (int d = 0; d < 3; ++d) grid.axis[d] = Axis(graded_nodes(0, p.length[d], p.n[d], p.stretch[d]), p.periodic[d]);
    Int3 bricks{1, 1, 1};
    for (int left = ranks_of(MPI_COMM_WORLD); left > 1; left /= 2) {
      int best = 2;
      for (int d = 1; d >= 0; --d)
        if (double(p.n[d]) / bricks[d] > double(p.n[best]) / bricks[best]) best = d;
      bricks[best] *= 2;
    }
    std::array<std::vector<int>, 3> cuts;
    for (int d = 0; d < 3; ++d) cuts[d] = cuts_even(grid.axis[d], bricks[d]);
    if (empty)
      for (int d = 0; d < 3; ++d)
        if (bricks[d] > 1) cuts[d][bricks[d] - 1] = p.n[d];
    layout = Layout(grid, cuts);
    own = layout.cells(rank_of(MPI_COMM_WORLD));
    for (int d = 0; d < 3; ++d) {
      conductance[d].reset(layout.faces(d, rank_of(MPI_COMM_WORLD)));
      for_each(conductance[d].box(), [&](int i, int j, int k) { conductance[d](i, j, k) = g(d, i, j, k); });
    }
    phi.reset(own.grown(2));
    b.reset(own.grown(2));
    const double shift = singular ? mean() : 0;
    for_each(own, [&](int i, int j, int k) {
      phi(i, j, k) = exact(i, j, k) - shift;
      b(i, j, k) = applied(i, j, k);
    });
  }

  /// Cells without any open face keep the first guess, 0.
  double exact(int i, int j, int k) const { return coefficient(i, j, k) > 0 ? noise(i, j, k, 1) - 0.5 : 0; }

  double coefficient(int i, int j, int k) const {
    return problem.coefficient(grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k));
  }

  /// Conductance of the low face of a cell in direction d: two half cells in series.
  double g(int d, int i, int j, int k) const {
    Int3 high{i, j, k}, low{i, j, k};
    const int n = problem.n[d];
    const double area = grid.area(d, i, j, k);
    if (problem.periodic[d]) {
      high[d] = (high[d] + n) % n;
      low[d] = (high[d] + n - 1) % n;
    } else {
      low[d] = high[d] - 1;
      if (high[d] == 0 || high[d] == n) {
        const bool open = problem.outlet == Outlet::kAll || (problem.outlet == Outlet::kTop && d == 2 && high[d] == n);
        const Int3 in = high[d] == 0 ? high : low;
        return open ? coefficient(in[0], in[1], in[2]) * area / (0.5 * grid.axis[d].width(in[d])) : 0.0;
      }
    }
    return area / (0.5 * grid.axis[d].width(high[d]) / coefficient(high[0], high[1], high[2]) +
                   0.5 * grid.axis[d].width(low[d]) / coefficient(low[0], low[1], low[2]));
  }

  /// Sum over the faces of g (phi_neighbour - phi_cell), from the definition.
  double applied(int i, int j, int k) const {
    double sum = 0;
    for (int d = 0; d < 3; ++d)
      for (int side : {-1, 1}) {
        Int3 face{i, j, k}, nb{i, j, k};
        if (side == 1) ++face[d];
        nb[d] += side;
        const int n = problem.n[d];
        bool outside = false;
        if (problem.periodic[d])
          nb[d] = (nb[d] + n) % n;
        else
          outside = nb[d] < 0 || nb[d] >= n;
        // A periodic direction of one cell: the cell is its own neighbour, and the term vanishes by itself.
        sum += g(d, face[0], face[1], face[2]) * ((outside ? 0.0 : exact(nb[0], nb[1], nb[2])) - exact(i, j, k));
      }
    return sum;
  }

  /// Mean of phi over the volume.
  double mean() const {
    double sum = 0, volume = 0;
    for_each(grid.cells(), [&](int i, int j, int k) {
      sum += grid.volume(i, j, k) * exact(i, j, k);
      volume += grid.volume(i, j, k);
    });
    return sum / volume;
  }

  double max_over_ranks(double x) const {
    MPI_Allreduce(MPI_IN_PLACE, &x, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return x;
  }
  double largest_error(const CellField<FineGrid>& found) const {
    double e = 0;
    for_each(own, [&](int i, int j, int k) { e = std::max(e, std::abs(found(i, j, k) - phi(i, j, k))); });
    return max_over_ranks(e);
  }

  /// |b - A found| / |b|, from the definition; the halo is brought by the exchange of the fluid's fields.
  double residual(CellField<FineGrid> found) const {
    std::vector<Box> wanted = layout.all_cells();
    for (Box& w : wanted) w = w.empty() ? w : w.grown(1);
    BlockExchange exchange(MPI_COMM_WORLD, layout.all_cells(), wanted, problem.n, problem.periodic);
    exchange.bring(std::vector<Array3<double>*>{&found});
    double sum[2] = {0, 0};
    for_each(own, [&](int i, int j, int k) {
      double r = b(i, j, k);
      for (int d = 0; d < 3; ++d)
        for (int side : {-1, 1}) {
          Int3 face{i, j, k}, nb{i, j, k};
          if (side == 1) ++face[d];
          nb[d] += side;
          const bool outside = !problem.periodic[d] && (nb[d] < 0 || nb[d] >= problem.n[d]);
          r -= g(d, face[0], face[1], face[2]) * ((outside ? 0.0 : found(nb[0], nb[1], nb[2])) - found(i, j, k));
        }
      sum[0] += r * r;
      sum[1] += b(i, j, k) * b(i, j, k);
    });
    MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return std::sqrt(sum[0] / sum[1]);
  }

  struct Result {
    int iterations;
    CellField<FineGrid> phi;
  };
  Result solve(double rtol) const {
    PressureSolver solver(MPI_COMM_WORLD, grid, layout, rtol);
    solver.set_operator(conductance, singular);
    Result r{0, CellField<FineGrid>(own.grown(2))};
    r.iterations = solver.solve(b, r.phi);
    return r;
  }
};

inline double bed(double contrast, double z, double top) {
  return z < top ? 1 / contrast : 1;
}

/// A bed with round bubbles in it, as the drag makes the coefficient: sharp jumps that no coarse grid follows.
inline double bubbles(double contrast, double x, double z) {
  const double centre[3][3] = {{0.3, 0.2, 0.13}, {0.62, 0.35, 0.17}, {0.45, 0.52, 0.09}};
  for (const auto& c : centre)
    if (std::hypot(x - c[0], z - c[1]) < c[2]) return 1;
  return bed(contrast, z, 0.6);
}

inline std::vector<Problem> problems() {
  std::vector<Problem> all;
  auto add = [&](const std::string& name, Int3 n) -> Problem& {
    Problem p;
    p.name = name;
    p.n = n;
    p.length = {double(n[0]), double(n[1]), double(n[2])};
    all.push_back(p);
    return all.back();
  };
  add("uniform", {16, 16, 16});
  add("prime sizes", {17, 13, 31});
  add("1 x n", {1, 1, 211});
  add("n x 1", {97, 1, 1});
  add("n x 1 x n", {45, 1, 60});
  add("one cell", {1, 1, 1});
  add("two cells", {2, 1, 1});
  add("all sides open", {15, 16, 17}).outlet = Outlet::kAll;
  {
    Problem& p = add("stretched 1.3 in x", {16, 16, 16});
    p.length = {1, 1, 1};
    p.stretch = {1.3, 1, 1};
  }
  {
    Problem& p = add("stretched 1.3 in x y z", {16, 15, 14});
    p.length = {1, 1, 1};
    p.stretch = {1.3, 1.3, 1 / 1.3};
  }
  add("cells 1:1:20", {20, 20, 20}).length = {1, 1, 20};
  add("cells 20:1:1", {12, 20, 20}).length = {12 * 20, 20, 20};
  add("cells 1:5:20", {20, 20, 20}).length = {1, 5, 20};
  add("101 x 1 x 7", {101, 1, 7});
  add("prime sizes, cells 1:20:1", {17, 13, 31}).length = {17, 13 * 20, 31};
  {
    Problem& p = add("1 x 1 x n, stretched 1.3", {1, 1, 24});
    p.stretch = {1, 1, 1.3};
    Problem& q = add("n x 1 x n, cells 20:1:1, stretched 1.3 in z", {45, 1, 20});
    q.length = {45 * 20, 1, 20};
    q.stretch = {1, 1, 1.3};
    Problem& r = add("bubbles, one cell deep, contrast 10000, cells 1:1:20", {61, 1, 83});
    r.length = {1, 0.02, 20};
    r.coefficient = [](double x, double, double z) { return bubbles(1e4, x, z / 20); };
    Problem& t = add("packed bed against gas as the solver sees it, prime sizes", {17, 13, 31});
    t.coefficient = [](double x, double y, double z) {  // eps/(1.5 rho eps/dt + beta), eps from 0.35 to 1, times rho/dt
      const double eps = z < 17.3 ? 0.35 + 0.2 * noise(int(x), int(y), int(z), 7) : 1, beta = 3000 * (1 - eps) / eps;
      return eps / (1.5 * eps + beta);
    };
  }
  for (double contrast : {10.0, 1000.0}) {
    Problem& p = add("bed with a coefficient " + std::to_string(int(contrast)) + " times smaller", {22, 6, 60});
    p.coefficient = [=](double, double, double z) { return bed(contrast, z, 25.3); };
    Problem& q = add("bubbles, contrast " + std::to_string(int(contrast)), {40, 8, 40});
    q.length = {1, 0.2, 1};
    q.coefficient = [=](double x, double, double z) { return bubbles(contrast, x, z); };
  }
  add("an obstacle", {20, 9, 25}).coefficient = [](double x, double y, double z) {
    return std::abs(x - 11) < 4.6 && y < 6.1 && std::abs(z - 9) < 3.2 ? 0.0 : 1.0;
  };
  add("periodic in x", {16, 12, 16}).periodic = {true, false, false};
  add("periodic in x and y, odd", {15, 9, 12}).periodic = {true, true, false};
  add("periodic in x, two cells", {2, 9, 20}).periodic = {true, false, false};
  add("periodic in y, one cell", {20, 1, 20}).periodic = {false, true, false};
  {
    Problem& p = add("closed", {14, 13, 16});
    p.outlet = Outlet::kNone;
  }
  {
    Problem& p = add("periodic in all, odd", {15, 11, 13});
    p.periodic = {true, true, true};
    p.outlet = Outlet::kNone;
  }
  {
    Problem& p = add("periodic in all, stretched, closed but for that", {12, 3, 16});
    p.length = {1, 1, 1};
    p.stretch = {1, 1, 1.1};
    p.periodic = {true, true, true};
    p.outlet = Outlet::kNone;
  }
  return all;
}

}  // namespace twogrid_test
