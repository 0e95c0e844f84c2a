#include "coupling/control/coupling_error.h"

#include <cmath>

namespace twogrid {

void CouplingError::remember(const Particles& p, const std::vector<int>& who, const std::vector<ImplicitDrag>& drag) {
  before_.resize(who.size());
  for (std::size_t q = 0; q < who.size(); ++q) {
    const int i = who[q];
    const double* s = p.state[i];
    // What holding the flux has changed is in drag[q].seen.
    for (int d = 0; d < 3; ++d) {
      const double seen = p.step[i][kStepVelocity + d] + (drag[q].seen[d] - s[kFluidVelocity + d]);
      before_[q][d] = p.step[i][kDragCoefficient] * (seen - p.v[i][d]) + s[kPressureForce + d];
    }
  }
}

double CouplingError::measure(MPI_Comm comm, const Particles& p, const std::vector<int>& who) const {
  double sum[2] = {0, 0};
  for (std::size_t q = 0; q < who.size(); ++q) {
    const int i = who[q];
    const double* s = p.state[i];
    for (int d = 0; d < 3; ++d) {
      const double force =
          p.step[i][kDragCoefficient] * (p.step[i][kStepVelocity + d] - p.v[i][d]) + s[kPressureForce + d];
      const double jump = force - before_[q][d];
      sum[0] += 0.25 * jump * jump;
      sum[1] += force * force;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, comm);
  return sum[1] > 0 ? std::sqrt(sum[0] / sum[1]) : 0.0;
}

}  // namespace twogrid
