// A, the factor of u in the momentum balance: (a0 rho/dt + mu K) eps + beta; eps: the inertia share, K: friction of a
// one-cell gap's walls, of bodies' walls.
#pragma once

#include "cfd/grid/field.h"

namespace twogrid {

struct Inertia {
  double per_eps = 0;                             ///< a0 rho/dt + mu K, where K is the same everywhere (kg/(m3 s))
  const FaceField<FineGrid>* friction = nullptr;  ///< mu K' of faces, on top; null: none

  /// A of a row of faces normal to d from memory index m on; e: their inertia shares; beta: null where absent.
  void row(int d, std::ptrdiff_t m, const double* e, const double* beta, int n, double* __restrict A) const {
    if (friction) {
      const double* k = (*friction)[d].data() + m;
      for (int i = 0; i < n; ++i) A[i] = (per_eps + k[i]) * e[i];
    } else {
      for (int i = 0; i < n; ++i) A[i] = per_eps * e[i];
    }
    if (!beta) return;
    for (int i = 0; i < n; ++i) A[i] += beta[i];
  }
};

}  // namespace twogrid
