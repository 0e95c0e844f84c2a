#include "coupling/forces/mean_motion.h"

#include <algorithm>
#include <cmath>

#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

namespace {

bool feels_drag(const Particles& p, int i) {
  return p.takes_part(i) && p.step[i][kDragCoefficient] > 0;
}

}  // namespace

MeanMotion::MeanMotion(MeanMotionState& state, MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes,
                       const ParticleRegion& region, Spread spread, const std::array<bool, 3>& free_flux)
    : state_(state),
      comm_(comm),
      grid_(grid),
      nodes_(nodes),
      own_(nodes.cells(rank_of(comm))),
      spread_(spread),
      free_flux_(free_flux),
      domain_volume_(grid.domain_volume(comm)) {
  move_region(region);
}

void MeanMotion::move_region(const ParticleRegion& region) {
  window_ = Window(comm_, grid_, nodes_, region, spread_, 0.0);
  shape_ = window_.shape();
}

void MeanMotion::clear(int sums) {
  for (int s = 0; s < sums; ++s) window_sum_[s].assign(window_.box().count(), FourWholeNumbers{});
}

void MeanMotion::collect(int sums) {
  std::vector<Slot<FourWholeNumbers>> window, node;
  for (int s = 0; s < sums; ++s) {
    node_sum_[s].assign(own_.count(), FourWholeNumbers{});
    window.push_back({window_.box(), window_sum_[s].data(), 1});
    node.push_back({own_, node_sum_[s].data(), 1});
  }
  window_.add(window, node);
  if (const OpenNodes* families = grid_.open_nodes())
    for (const auto& sum : node) families->total(sum);
}

void MeanMotion::bring(int groups) {
  shown_.resize(window_.box().count() * groups);
  std::vector<Slot<FourNumbers>> own, window;
  for (int g = 0; g < groups; ++g) {
    own.push_back({own_, own_shown_.data() + g, groups});
    window.push_back({window_.box(), shown_.data() + g, groups});
  }
  window_.bring(own, window);
}

void MeanMotion::average_diameters(const Particles& p, const std::vector<int>& who, double largest_radius,
                                   double terms) {
  const FixedPoint cubes(8 * largest_radius * largest_radius * largest_radius, terms);
  const FixedPoint squares(4 * largest_radius * largest_radius, terms);
  clear(1);
  for (int i : who) {
    const double d = 2 * p.radius[i];
    const Four whole{cubes.whole(d * d * d), squares.whole(d * d), 0, 0};
    const auto add = [&](const auto& place) { scatter(place, shape_, whole, window_sum_[0].data()); };
    window_.cut() ? at<true>(p.x[i], add) : at<false>(p.x[i], add);
  }
  collect(1);
  own_shown_.assign(own_.count(), FourNumbers{});
  for (std::size_t m = 0; m < own_shown_.size(); ++m) {
    const auto& sum = node_sum_[0][m].at;
    const double square = squares.value(sum[1]);
    own_shown_[m].at[0] = square > 0 ? cubes.value(sum[0]) / square : 0.0;
  }
  bring(1);
}

double MeanMotion::diameter(const double x[3]) const {
  Four out;
  const auto read = [&](const auto& place) { gather<1>(place, shape_, shown_.data(), &out); };
  window_.cut() ? at<true>(x, read) : at<false>(x, read);
  return out[0];
}

void MeanMotion::sum_motion(const Particles& p, const std::vector<int>* who) {
  mass_unit_ = FixedPoint(state_.mass, state_.terms);
  window_.cut() ? add_motion<true>(p, who) : add_motion<false>(p, who);
}

template <bool kCut>
void MeanMotion::add_motion(const Particles& p, const std::vector<int>* who) {
  const double a = momentum_unit_.per_unit();
  const Four per_unit{a, a, a, mass_unit_.per_unit()};
  auto add = [&](int i) {
    const double m = p.mass[i], *v = p.v[i];
    Four whole = Four{m * v[0], m * v[1], m * v[2], m} * per_unit;
    FixedPoint::to_whole(whole);
    at<kCut>(p.x[i], [&](const auto& place) { scatter(place, shape_, whole, window_sum_[kMotion].data()); });
  };
  if (who)
    for (int i : *who) add(i);
  else
    for (int i = 0; i < p.n; ++i)
      if (feels_drag(p, i)) add(i);
}

template <bool kCut>
void MeanMotion::add_flux_and_drag(const Particles& p, const std::vector<int>& who,
                                   const std::vector<FourNumbers>& flux_velocity, const Largest& largest, bool drag) {
  const FixedPoint b_unit(largest.drag_coefficient, largest.terms), force_unit(largest.drag, largest.terms);
  const double f = force_unit.per_unit();
  const Four force_per_unit{f, f, f, b_unit.per_unit()};
  for (std::size_t q = 0; q < who.size(); ++q) {
    const int i = who[q];
    const double *u = p.step[i] + kStepVelocity, b = p.step[i][kDragCoefficient];
    Four flux = p.mass[i] * four_at(flux_velocity[q].at).row * momentum_unit_.per_unit(), force{0, 0, 0, 0};
    flux[3] = 0;
    FixedPoint::to_whole(flux);
    if (drag) {
      for (int d = 0; d < 3; ++d) force[d] = b * (u[d] - p.v[i][d]);
      force[3] = b;
      force *= force_per_unit;
      FixedPoint::to_whole(force);
    }
    at<kCut>(p.x[i], [&](const auto& place) {
      scatter(place, shape_, flux, window_sum_[kFlux].data());
      if (drag) scatter(weights_like_home(place, shape_, shown_.data(), 1), force, window_sum_[kDrag].data());
    });
  }
}

void MeanMotion::couple(const Particles& p, const std::vector<int>& who, const std::vector<FourNumbers>& flux_velocity,
                        const CellField<ParticleGrid>& eps, const Largest& largest, bool drag) {
  if (state_.v_n[0].size() == 0) {
    state_.beta.reset(own_);
    for (int d = 0; d < 3; ++d) state_.v_flux[d].reset(own_), state_.v_n[d].reset(own_);
  }
  state_.drag = drag, state_.mass = largest.mass, state_.terms = largest.terms;
  momentum_unit_ = FixedPoint(largest.momentum, largest.terms);
  const FixedPoint b_unit(largest.drag_coefficient, largest.terms), force_unit(largest.drag, largest.terms);
  if (drag) {  // for weights like home
    own_shown_.assign(own_.count(), FourNumbers{});
    for_each(own_, [&](int i, int j, int k) { own_shown(i, j, k, 0, 1).at[3] = eps(i, j, k); });
    bring(1);
  }
  const int sums = drag ? kSums : kDrag;
  clear(sums);
  sum_motion(p, &who);
  window_.cut() ? add_flux_and_drag<true>(p, who, flux_velocity, largest, drag)
                : add_flux_and_drag<false>(p, who, flux_velocity, largest, drag);
  collect(sums);
  if (drag) own_shown_.assign(2 * own_.count(), FourNumbers{});
  for_each(own_, [&](int i, int j, int k) {
    const double e = eps(i, j, k);
    const std::size_t n = place(i, j, k);
    const double mass = mass_unit_.value(node_sum_[kMotion][n].at[3]);
    const double inverse = mass > 0 ? 1 / mass : 0.0;
    for (int d = 0; d < 3; ++d) {
      state_.v_n[d](i, j, k) = momentum_unit_.value(node_sum_[kMotion][n].at[d]) * inverse;
      state_.v_flux[d](i, j, k) = momentum_unit_.value(node_sum_[kFlux][n].at[d]) * inverse;
    }
    if (!drag) return;
    const double volume = grid_.shown_volume(i, j, k), scale = volume > 0 ? 1 / (e * volume) : 0.0;
    FourNumbers& shown = own_shown(i, j, k, 0, 2);
    for (int d = 0; d < 3; ++d) shown.at[d] = force_unit.value(node_sum_[kDrag][n].at[d]) * scale;
    state_.beta(i, j, k) = shown.at[3] = b_unit.value(node_sum_[kDrag][n].at[3]) * scale;
    own_shown(i, j, k, 1, 2).at[3] = e;
  });
  if (drag) bring(2);
}

void MeanMotion::drag_at(const double x[3], double& beta, Vec3& d) const {
  Four out[2] = {};
  const auto read = [&](const auto& place) {
    gather<2>(weights_like_home(place, shape_, shown_.data() + 1, 2), shown_.data(), out);
  };
  window_.cut() ? at<true>(x, read) : at<false>(x, read);
  beta = out[0][3];
  d = {out[0][0], out[0][1], out[0][2]};
}

void MeanMotion::update(const Particles& p, const CellField<ParticleGrid>& eps) {
  double mine = 0, largest = 0;
  for (int i = 0; i < p.n; ++i)
    if (feels_drag(p, i))
      for (int d = 0; d < 3; ++d) mine = std::max(mine, p.mass[i] * std::abs(p.v[i][d]));
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  momentum_unit_ = FixedPoint(largest, state_.terms);
  clear(1);
  sum_motion(p, nullptr);
  collect(1);
  // First the held part of the flux, eps_s (v - v_flux), and v.
  const int groups = state_.drag ? 2 : 1;
  own_shown_.assign(groups * own_.count(), FourNumbers{});
  double flux[3] = {0, 0, 0}, mean_flux[3] = {0, 0, 0};
  for_each(own_, [&](int i, int j, int k) {
    const auto& sum = node_sum_[kMotion][place(i, j, k)].at;
    const double mass = mass_unit_.value(sum[3]);
    const double solid = 1 - eps(i, j, k), volume = grid_.volume(i, j, k);
    for (int d = 0; d < 3; ++d) {
      const double v = mass > 0 ? momentum_unit_.value(sum[d]) / mass : state_.v_n[d](i, j, k);
      const double held = mass > 0 ? solid * (v - state_.v_flux[d](i, j, k)) : 0.0;
      own_shown(i, j, k, 0, groups).at[d] = held;
      if (state_.drag) own_shown(i, j, k, 1, groups).at[d] = v;
      flux[d] += held * volume;
    }
  });
  if (free_flux_[0] || free_flux_[1] || free_flux_[2]) {
    MPI_Allreduce(flux, mean_flux, 3, MPI_DOUBLE, MPI_SUM, comm_);
    for (int d = 0; d < 3; ++d) mean_flux[d] = free_flux_[d] ? mean_flux[d] / domain_volume_ : 0.0;
  }
  for_each(own_, [&](int i, int j, int k) {
    const double inverse = 1 / eps(i, j, k);
    for (int d = 0; d < 3; ++d) {
      double& c = own_shown(i, j, k, 0, groups).at[d];
      c = (c - mean_flux[d]) * inverse;
      if (!state_.drag) continue;
      double& v = own_shown(i, j, k, 1, groups).at[d];
      v = -state_.beta(i, j, k) * (c + v - state_.v_n[d](i, j, k));
    }
  });
  bring(groups);
}

void MeanMotion::change_at(const double x[3], Vec3& c, Vec3& pressure) const {
  Four out[2] = {};
  const auto read = [&](const auto& place) {
    if (state_.drag)
      gather<2>(place, shape_, shown_.data(), out);
    else
      gather<1>(place, shape_, shown_.data(), out);
  };
  window_.cut() ? at<true>(x, read) : at<false>(x, read);
  c = {out[0][0], out[0][1], out[0][2]};
  pressure = {out[1][0], out[1][1], out[1][2]};
}

}  // namespace twogrid
