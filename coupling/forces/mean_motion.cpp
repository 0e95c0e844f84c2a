#include "coupling/forces/mean_motion.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

namespace {

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

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
      domain_volume_(grid.axis[0].length() * grid.axis[1].length() * grid.axis[2].length()) {
  for (auto& a : node_sum_) a.reset(own_);
  for (auto& a : shown_) a.reset(own_);
  move_region(region);
}

void MeanMotion::move_region(const ParticleRegion& region) {
  window_ = Window(comm_, grid_, nodes_, region, spread_, 0.0);
  for (auto& a : window_sum_) a.reset(window_.box());
  for (auto& a : window_shown_) a.reset(window_.box());
}

void MeanMotion::collect(int n) {
  std::vector<const Array3<long long>*> window;
  std::vector<Array3<long long>*> node;
  for (int c = 0; c < n; ++c) {
    node_sum_[c].fill(0);
    window.push_back(&window_sum_[c]);
    node.push_back(&node_sum_[c]);
  }
  window_.add(window, node);
}

void MeanMotion::bring(int first, int n) {
  std::vector<const Array3<double>*> node;
  std::vector<Array3<double>*> window;
  for (int c = first; c < first + n; ++c) {
    node.push_back(&shown_[c]);
    window.push_back(&window_shown_[c]);
  }
  window_.bring<double>(node, window);
}

void MeanMotion::average_diameters(const Particles& p, const std::vector<int>& who, double largest_radius,
                                   double terms) {
  const FixedPoint cubes(8 * largest_radius * largest_radius * largest_radius, terms);
  const FixedPoint squares(4 * largest_radius * largest_radius, terms);
  for (int c = 0; c < 2; ++c) window_sum_[c].fill(0);
  for (int i : who) {
    const double d = 2 * p.radius[i];
    window_.weights(p.x[i], stencil_);
    scatter(stencil_, cubes.quantise(d * d * d), window_sum_[0]);
    scatter(stencil_, squares.quantise(d * d), window_sum_[1]);
  }
  collect(2);
  for (std::size_t m = 0; m < shown_[0].size(); ++m) {
    const double square = squares.value(node_sum_[1].data()[m]);
    shown_[0].data()[m] = square > 0 ? cubes.value(node_sum_[0].data()[m]) / square : 0.0;
  }
  bring(0, 1);
}

double MeanMotion::diameter(const double x[3]) {
  window_.weights(x, stencil_);
  const double* field[1] = {window_shown_[0].data()};
  double out[1];
  gather<1>(stencil_, window_shown_[0], field, out);
  return out[0];
}

void MeanMotion::sum_motion(const Particles& p, const std::vector<int>* who) {
  mass_unit_ = FixedPoint(state_.mass, state_.terms);
  for (int c = 0; c < 4; ++c) window_sum_[c].fill(0);
  auto add = [&](int i) {
    window_.weights(p.x[i], stencil_);
    scatter(stencil_, mass_unit_.quantise(p.mass[i]), window_sum_[0]);
    for (int d = 0; d < 3; ++d) scatter(stencil_, momentum_unit_.quantise(p.mass[i] * p.v[i][d]), window_sum_[1 + d]);
  };
  if (who)
    for (int i : *who) add(i);
  else
    for (int i = 0; i < p.n; ++i)
      if (feels_drag(p, i)) add(i);
}

void MeanMotion::couple(const Particles& p, const std::vector<int>& who, const std::vector<FourNumbers>& flux_velocity,
                        const CellField<ParticleGrid>& eps, const Largest& largest, bool drag) {
  if (state_.v_n[0].size() == 0) {
    state_.beta.reset(own_);
    for (int d = 0; d < 3; ++d) state_.v_flux[d].reset(own_), state_.v_n[d].reset(own_);
  }
  state_.drag = drag, state_.mass = largest.mass, state_.terms = largest.terms;
  if (drag) {
    for_each(own_, [&](int i, int j, int k) { shown_[kShownEps](i, j, k) = eps(i, j, k); });
    bring(kShownEps, 1);
  }
  momentum_unit_ = FixedPoint(largest.momentum, largest.terms);
  const FixedPoint b_unit(largest.drag_coefficient, largest.terms), force_unit(largest.drag, largest.terms);
  sum_motion(p, &who);
  const int sums = drag ? 11 : 7;
  for (int c = 4; c < sums; ++c) window_sum_[c].fill(0);
  for (std::size_t q = 0; q < who.size(); ++q) {
    const int i = who[q];
    window_.weights(p.x[i], stencil_);
    for (int d = 0; d < 3; ++d)
      scatter(stencil_, momentum_unit_.quantise(p.mass[i] * flux_velocity[q].at[d]), window_sum_[4 + d]);
    if (!drag) continue;
    const double* u = p.step[i] + kStepVelocity;
    const double b = p.step[i][kDragCoefficient];
    const double sum = weights_like_home(stencil_, window_shown_[kShownEps], weights_);
    scatter(stencil_, weights_, sum, b_unit.quantise(b), window_sum_[7]);
    for (int d = 0; d < 3; ++d)
      scatter(stencil_, weights_, sum, force_unit.quantise(b * (u[d] - p.v[i][d])), window_sum_[8 + d]);
  }
  collect(sums);
  for_each(own_, [&](int i, int j, int k) {
    const double e = eps(i, j, k);
    const double mass = mass_unit_.value(node_sum_[0](i, j, k));
    const double inverse = mass > 0 ? 1 / mass : 0.0;
    for (int d = 0; d < 3; ++d) {
      state_.v_n[d](i, j, k) = momentum_unit_.value(node_sum_[1 + d](i, j, k)) * inverse;
      state_.v_flux[d](i, j, k) = momentum_unit_.value(node_sum_[4 + d](i, j, k)) * inverse;
    }
    if (!drag) return;
    const double scale = 1 / (e * grid_.volume(i, j, k));
    state_.beta(i, j, k) = shown_[0](i, j, k) = b_unit.value(node_sum_[7](i, j, k)) * scale;
    for (int d = 0; d < 3; ++d) shown_[1 + d](i, j, k) = force_unit.value(node_sum_[8 + d](i, j, k)) * scale;
  });
  if (drag) bring(0, 4);
}

void MeanMotion::drag_at(const double x[3], double& beta, Vec3& d) {
  window_.weights(x, stencil_);
  const double* field[4];
  double out[4];
  for (int c = 0; c < 4; ++c) field[c] = window_shown_[c].data();
  const double sum = weights_like_home(stencil_, window_shown_[kShownEps], weights_);
  gather<4>(stencil_, weights_, sum, window_shown_[0], field, out);
  beta = out[0];
  d = {out[1], out[2], out[3]};
}

void MeanMotion::update(const Particles& p, const CellField<ParticleGrid>& eps) {
  double mine = 0, largest = 0;
  for (int i = 0; i < p.n; ++i)
    if (feels_drag(p, i))
      for (int d = 0; d < 3; ++d) mine = std::max(mine, p.mass[i] * std::abs(p.v[i][d]));
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  momentum_unit_ = FixedPoint(largest, state_.terms);
  sum_motion(p, nullptr);
  collect(4);
  // First the held part of the flux, eps_s (v - v_flux); shown_[3 + d] keeps v.
  double flux[3] = {0, 0, 0}, mean_flux[3] = {0, 0, 0};
  for_each(own_, [&](int i, int j, int k) {
    const double mass = mass_unit_.value(node_sum_[0](i, j, k));
    const double solid = 1 - eps(i, j, k), volume = grid_.volume(i, j, k);
    for (int d = 0; d < 3; ++d) {
      const double v = mass > 0 ? momentum_unit_.value(node_sum_[1 + d](i, j, k)) / mass : state_.v_n[d](i, j, k);
      const double held = mass > 0 ? solid * (v - state_.v_flux[d](i, j, k)) : 0.0;
      shown_[d](i, j, k) = held;
      shown_[3 + d](i, j, k) = v;
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
      const double c = (shown_[d](i, j, k) - mean_flux[d]) * inverse, v = shown_[3 + d](i, j, k);
      shown_[d](i, j, k) = c;
      shown_[3 + d](i, j, k) = state_.drag ? -state_.beta(i, j, k) * (c + v - state_.v_n[d](i, j, k)) : 0.0;
    }
  });
  bring(0, state_.drag ? 6 : 3);
}

void MeanMotion::change_at(const double x[3], Vec3& c, Vec3& pressure) {
  window_.weights(x, stencil_);
  const double* field[6];
  double out[6];
  for (int q = 0; q < 6; ++q) field[q] = window_shown_[q].data();
  if (state_.drag) {
    gather<6>(stencil_, window_shown_[0], field, out);
  } else {
    const double* three[3] = {field[0], field[1], field[2]};
    double o[3];
    gather<3>(stencil_, window_shown_[0], three, o);
    for (int d = 0; d < 3; ++d) out[d] = o[d], out[3 + d] = 0;
  }
  c = {out[0], out[1], out[2]};
  pressure = {out[3], out[4], out[5]};
}

}  // namespace twogrid
