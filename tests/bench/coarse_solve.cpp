// What the pressure multigrid's coarsest level costs when it has many cells. Bricks are not merged across ranks, so that level has at
// least one cell a rank; every rank solves it by the same sparse LDL^T as cfd/multigrid.cpp. Prints, for n x n x n cells, CPU ms of the
// factorisation (once a fluid step, pattern known) and of a solve (once an iteration), and the entries of L. For cost_model.py.
//
//   cases/build.sh coarse_solve && build/tests/coarse_solve      (figures in cost_model.py: with -march=native)
#include <time.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstdio>
#include <vector>

static double seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

int main() {
  std::printf("cells factor_ms solve_ms entries\n");
  for (int n : {4, 6, 8, 10, 13, 16, 22}) {
    std::vector<Eigen::Triplet<double>> entry;
    const int total = n * n * n, step[3] = {1, n, n * n};
    for (int c = 0; c < total; ++c) {
      const int at[3] = {c % n, c / n % n, c / n / n};
      entry.emplace_back(c, c, 6 + (at[2] == n - 1));
      for (int d = 0; d < 3; ++d)
        if (at[d] > 0) entry.emplace_back(c, c - step[d], -1.0);
    }
    Eigen::SparseMatrix<double> matrix(total, total);
    matrix.setFromTriplets(entry.begin(), entry.end());
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor;
    factor.analyzePattern(matrix);
    Eigen::VectorXd b = Eigen::VectorXd::Random(total), x;
    const int repeats = n < 13 ? 50 : 3;
    double t = seconds();
    for (int i = 0; i < repeats; ++i) factor.factorize(matrix);
    const double f = (seconds() - t) / repeats;
    t = seconds();
    for (int i = 0; i < 10 * repeats; ++i) x = factor.solve(b);
    const double s = (seconds() - t) / (10 * repeats);
    const Eigen::SparseMatrix<double> l = factor.matrixL();
    std::printf("%d %.4f %.5f %ld\n", total, 1e3 * f, 1e3 * s, long(l.nonZeros()));
  }
}
