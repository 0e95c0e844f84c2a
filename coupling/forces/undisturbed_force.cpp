#include "coupling/forces/undisturbed_force.h"

#include "cfd/parallel/ranks.h"

namespace twogrid {

UndisturbedForce::UndisturbedForce(MPI_Comm comm, const Fluid& fluid, FaceField<FineGrid>& r) : r_(r) {
  const int rank = rank_of(comm);
  std::array<std::vector<Box>, 3> owned, wanted;
  for (int d = 0; d < 3; ++d) {
    owned[d] = fluid.layout().all_faces(d);
    wanted[d] = with_halo(owned[d], {1, 1, 1});
    own_[d] = owned[d][rank];
    r_[d].reset(wanted[d][rank]);
  }
  halo_ = FaceExchange(comm, owned, wanted, fluid.grid().n(), fluid.grid().periodic());
}

double mean_density(MPI_Comm comm, const Particles& p, const std::vector<int>& who, double otherwise) {
  double sums[2] = {0, 0}, all[2];
  for (int i : who) sums[0] += p.mass[i], sums[1] += sphere_volume(p.radius[i]);
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm);
  return all[1] > 0 ? all[0] / all[1] : otherwise;
}

void UndisturbedForce::update(const Fluid& fluid, const CellField<FineGrid>& eps, const Interphase& exchange,
                              double particle_density) {
  fluid.open_shares() ? renew<true>(fluid, eps, exchange, particle_density)
                      : renew<false>(fluid, eps, exchange, particle_density);
  halo_.bring(r_);
}

template <bool kOpenShares>
void UndisturbedForce::renew(const Fluid& fluid, const CellField<FineGrid>& eps, const Interphase& exchange,
                             double particle_density) {
  const OpenShares* open = fluid.open_shares();
  const double density_ratio = fluid.density() / particle_density;
  for (int d = 0; d < 3; ++d) {
    const Axis& a = fluid.grid().axis[d];
    const Array3<FaceState>& state = fluid.face_state(d);
    const FaceComponent<FineGrid>& gradient = fluid.mean_pressure_gradient()[d];
    const FaceComponent<FineGrid>& u = fluid.mean_velocity()[d];
    const Box& own = own_[d];
    const int n = own.size(0);
    source_.resize(n), beta_.resize(n);
    for (int k = own.lo[2]; k < own.hi[2]; ++k)
      for (int j = own.lo[1]; j < own.hi[1]; ++j) {
        const double *source = exchange.source_row(d, own.lo[0], j, k, n, source_.data()),
                     *beta = exchange.beta_row(d, own.lo[0], j, k, n, beta_.data());
        for (int q = 0; q < n; ++q) {
          const int i = own.lo[0] + q;
          if (state(i, j, k) == FaceState::kFixed) continue;
          Int3 c{i, j, k}, under = c;
          --under[d];
          double h0 = a.width(under[d]), h1 = a.width(c[d]);
          if (kOpenShares) h0 *= open->theta()(under[0], under[1], under[2]), h1 *= open->theta()(i, j, k);
          const double e = (h0 * eps(under[0], under[1], under[2]) + h1 * eps(i, j, k)) / (h0 + h1);
          // The exchange is that of the face's whole volume.
          const double whole = kOpenShares ? 1 / open->theta_f()[d](i, j, k) : 1.0;
          const double balance = gradient(i, j, k) - (source ? (source[q] - beta[q] * u(i, j, k)) * whole : 0.0);
          const double w = e / (1 + (1 - e) * density_ratio);
          double& r = r_[d](i, j, k);
          r += w * (-balance / e - r);
        }
      }
  }
}

}  // namespace twogrid
