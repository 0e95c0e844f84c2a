#include "cfd/fluid/flow_rate.h"

#include <cmath>

#include "cfd/pressure/pressure_solver.h"

namespace twogrid {

void FlowRate::hold(FluidState& state, const Interphase& exchange, const FaceField<FineGrid>& conductance,
                    PressureSolver& solver, FaceField<FineGrid>& u_next) {
  for (int d = 0; d < 3; ++d) {
    if (!settings_.flow_rate_set[d]) continue;
    // Potential that answers a unit mean gradient in d: div(g (grad response + e_d)) = 0.
    if (state.response.size() == 0) state.response.reset(domain_.local);
    if (response_rhs_.size() == 0) response_rhs_.reset(domain_.own);
    const std::ptrdiff_t s = state.p.stride(d);
    const FaceComponent<FineGrid>& g = conductance[d];  // the pressure solver has filled its halo
    const double total_volume = domain_.volume();
    double largest = 0;
    for_each(domain_.own, [&](int i, int j, int k) {
      const std::ptrdiff_t m = state.p.index(i, j, k);
      const Int3 x{i, j, k};
      largest = std::max(largest, g.data()[m] * domain_.measures.axis(d).face_width(x[d]));
      response_rhs_(i, j, k) = -(g.data()[m + s] * domain_.measures.axis(d).face_width(x[d] + 1) -
                                 g.data()[m] * domain_.measures.axis(d).face_width(x[d]));
    });
    // Where the conductance is uniform, what stands on the right is rounding alone.
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, domain_.comm);
    const double cells = domain_.cells();
    const double target = std::max(solver.rtol(), 4e-15) * largest * std::sqrt(cells);
    solver.solve(response_rhs_, state.response, target);
    domain_.fill(state.response);
    domain_.boundaries.apply_correction(state.response);
    // Mean flux now, and its answer to a unit gradient.
    std::array<double, 2> mean{0, 0};
    for_each(domain_.faces[d], [&](int i, int j, int k) {
      const std::ptrdiff_t m = state.p.index(i, j, k);
      const Int3 x{i, j, k};
      const double w = domain_.measures.axis(d).face_width(x[d]), A = domain_.measures.area(d, i, j, k);
      const double answer =
          g.data()[m] * (w + state.response.data()[m] - state.response.data()[m - s]);  // m3/s per Pa/m
      mean[0] += state.eps_f[d].data()[m] * u_next[d].data()[m] * A * w;
      mean[1] += answer * w;
    });
    MPI_Allreduce(MPI_IN_PLACE, mean.data(), 2, MPI_DOUBLE, MPI_SUM, domain_.comm);
    const double wanted = settings_.flow_rate[d] - exchange.particle_flux[d];
    const double change = (mean[0] / total_volume - wanted) / (mean[1] / total_volume);
    state.imposed[d] += change;
    for (int c = 0; c < 3; ++c) {
      const std::ptrdiff_t sc = state.p.stride(c);
      for_each(domain_.faces[c], [&](int i, int j, int k) {
        const std::ptrdiff_t m = state.p.index(i, j, k);
        const Int3 x{i, j, k};
        const double drop = state.response.data()[m] - state.response.data()[m - sc] +
                            (c == d ? domain_.measures.axis(d).face_width(x[d]) : 0.0);
        u_next[c].data()[m] -=
            change * conductance[c].data()[m] / (state.eps_f[c].data()[m] * domain_.measures.area(c, i, j, k)) * drop;
      });
    }
    for_each(domain_.own, [&](int i, int j, int k) { state.phi(i, j, k) += change * state.response(i, j, k); });
    domain_.fill(u_next);
  }
}

}  // namespace twogrid
