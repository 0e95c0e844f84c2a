// A, the factor of u in the momentum balance: a0 rho eps/dt + beta + the friction of a one-cell gap's walls.
#pragma once

namespace twogrid {

struct Inertia {
  double per_eps = 0;  ///< A = per_eps eps + beta (kg/(m3 s))

  /// A of a row of faces; beta: null where absent.
  void row(const double* e, const double* beta, int n, double* __restrict A) const {
    for (int i = 0; i < n; ++i) A[i] = per_eps * e[i];
    if (!beta) return;
    for (int i = 0; i < n; ++i) A[i] += beta[i];
  }
};

}  // namespace twogrid
