#include "coupling/forces/momentum_exchange.h"

#include <algorithm>
#include <cmath>

#include "coupling/particles/decay.h"

namespace twogrid {

namespace {

TWOGRID_VECTORISED void add_reactions(Reader& reader, const Particles& p, const std::vector<int>& who,
                                      const Places& places, const std::vector<ImplicitDrag>& drag,
                                      const Four& per_unit) {
  const WindowShape shape = reader.shape();
  FourWholeNumbers* const sum = reader.sum();
  reader.at_places(p, who, places, [&](std::size_t q, const auto& place) {
    scatter(place, shape, (drag[q].given * per_unit + kWhole) - kWhole, sum);
  });
}

}  // namespace

void MomentumExchange::react(const Particles& p, const Selection& selection, const Places& places,
                             const std::vector<ImplicitDrag>& drag, const Census& census, double interval,
                             bool completed, Ledger& ledger) {
  const std::array<FixedPoint, 2> scale{FixedPoint(census.reaction, census.terms),
                                        FixedPoint(census.response, census.terms)};
  const double force = scale[0].per_unit(), coefficient = scale[1].per_unit();
  reader_.clear_reaction();
  add_reactions(reader_, p, selection.inside(), places, drag, Four{force, force, force, coefficient});
  for (int i : selection.leaving()) {
    Four q{0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) q[d] = scale[0].whole(-p.step[i][kImpulse + d] / interval);
    reader_.react_at(p.x[i], q);
  }
  Vec3 held_back;
  reader_.collect(scale, source_, beta_, held_back);
  exchange_.source_rows = &source_;
  exchange_.beta_rows = &beta_;
  for (int d = 0; d < 3; ++d) ledger.wall[d] += held_back[d] * interval;
  if (completed)
    complete_drag(p, selection.inside(), places, drag, census.terms, interval, ledger);
  else
    for (auto& field : exchange_.source) field = {};
}

/// What a particle reads is a mean over faces, R_p u. In react() face f feels, of particle p, w_pf times
///   -I_p/D + b'_p (u_ref - u_f) = -I_p/D + b'_p (u_ref - R_p u) + b'_p (R_p u - u_f):
/// the last is drag on the fluid's own deviation from what the particle reads, with a coefficient that depends on the
/// interval. The coefficient wanted is b''_p = (m/T)(1 - exp(-b T/m)), T the time in which the particle crosses what it
/// reads: heavy particles resist the deviation with b in full, light ones would follow it, did they see it. The rest,
/// (b'' - b') (R_p u - u_f), is added here with u of the interval's begin. Its sum over the faces is zero: no particle
/// receives it. Being explicit it is kept below half of the implicit part.
double MomentumExchange::deviation_response(const Particles& p, int i) const {
  const double* s = p.state[i];
  const double b = s[kResponse];
  if (p.held(i)) return b;
  double v2 = 0, slip2 = 0;
  for (int d = 0; d < 3; ++d) {
    const double slip = s[kFluidVelocity + d] - p.v[i][d];
    v2 += p.v[i][d] * p.v[i][d];
    slip2 += slip * slip;
  }
  return b * mean_decay(b * read_length_ / (p.mass[i] * (std::sqrt(v2) + std::sqrt(slip2)) + 1e-300));
}

void MomentumExchange::complete_drag(const Particles& p, const std::vector<int>& who, const Places& places,
                                     const std::vector<ImplicitDrag>& drag, double terms, double interval,
                                     Ledger& ledger) {
  const FaceField<FineGrid>& u = fluid_.velocity();
  reader_.load({{&u}});
  double largest[2] = {0, 0}, all[2];
  deviations_.resize(who.size());
  reader_.at_places(p, who, places, [&](std::size_t q, const auto& place) {
    const double implicit = drag[q].given[3];
    const double b = std::clamp(deviation_response(p, who[q]) - implicit, -implicit, 0.5 * implicit);
    Four read;
    reader_.at<1>(place, &read);
    double* const deviation = deviations_[q].at;
    four_at(deviation).row = b * read;
    deviation[3] = b;
    for (int d = 0; d < 3; ++d) largest[0] = std::max(largest[0], std::abs(deviation[d]));
    largest[1] = std::max(largest[1], std::abs(b));
  });
  MPI_Allreduce(largest, all, 2, MPI_DOUBLE, MPI_MAX, comm_);
  const std::array<FixedPoint, 2> scale{FixedPoint(all[0], terms), FixedPoint(all[1], terms)};
  reader_.clear_reaction();
  reader_.at_places(p, who, places, [&](std::size_t q, const auto& place) {
    Four whole{0, 0, 0, 0};
    for (int c = 0; c < 4; ++c) whole[c] = scale[c < 3 ? 0 : 1].whole(deviations_[q].at[c]);
    reader_.react(place, whole);
  });
  Vec3 held_back;
  reader_.collect(scale, deviation_, deviation_beta_, held_back);
  for (int d = 0; d < 3; ++d) {
    ledger.wall[d] += held_back[d] * interval;
    const Box& b = reader_.map().faces(d);
    const int n = b.size(0);
    FaceComponent<FineGrid>& source = exchange_.source[d];
    source.reset(b);
    for (auto& r : rows_) r.resize(std::max(r.size(), std::size_t(n)));
    double *by = rows_[0].data(), *beta = rows_[1].data();
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        double* s = &source.data()[source.index(b.lo[0], j, k)];
        const double* v = &u[d].data()[u[d].index(b.lo[0], j, k)];
        source_.row(d, b.lo[0], j, k, n, s);
        deviation_.row(d, b.lo[0], j, k, n, by);
        deviation_beta_.row(d, b.lo[0], j, k, n, beta);
        for (int i = 0; i < n; ++i) s[i] += by[i] - beta[i] * v[i];
      }
  }
}

void MomentumExchange::count_reaction(double interval, Ledger& ledger) {
  const FaceField<FineGrid>& mean = fluid_.mean_velocity();
  for (int d = 0; d < 3; ++d) {
    const Box& b = reader_.map().faces(d);
    const int n = b.size(0);
    for (auto& r : rows_) r.resize(std::max(r.size(), std::size_t(n)));
    for (int k = b.lo[2]; k < b.hi[2]; ++k)
      for (int j = b.lo[1]; j < b.hi[1]; ++j) {
        const double *source = exchange_.source_row(d, b.lo[0], j, k, n, rows_[0].data()),
                     *beta = exchange_.beta_row(d, b.lo[0], j, k, n, rows_[1].data()),
                     *u = &mean[d].data()[mean[d].index(b.lo[0], j, k)];
        double* const force = rows_[2].data();
        for (int i = 0; i < n; ++i) force[i] = source[i] - beta[i] * u[i];
        ledger.reaction[d] += reader_.map().integral(d, j, k, force) * interval;
      }
  }
}

void MomentumExchange::set_particle_flux(const Particles& p, const std::vector<int>& who,
                                         const std::vector<FourNumbers>& flux_velocity) {
  Vec3 sum{0, 0, 0};
  for (std::size_t q = 0; q < who.size(); ++q)
    for (int d = 0; d < 3; ++d) sum[d] += sphere_volume(p.radius[who[q]]) * flux_velocity[q].at[d];
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, comm_);
  const auto& axis = fluid_.grid().axis;
  const OpenShares* open = fluid_.open_shares();
  const double volume = open ? open->volume() : axis[0].length() * axis[1].length() * axis[2].length();
  for (int d = 0; d < 3; ++d) exchange_.particle_flux[d] = sum[d] / volume;
}

}  // namespace twogrid
