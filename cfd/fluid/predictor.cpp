#include "cfd/fluid/predictor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cfd/measures/row_measures.h"
#include "cfd/momentum/viscous_solver.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

TWOGRID_VECTORISED void extrapolate_values(std::size_t n, double r, const double* now, const double* old,
                                           double* __restrict out) {
  for (std::size_t m = 0; m < n; ++m) out[m] = now[m] + r * (now[m] - old[m]);
}

TWOGRID_VECTORISED void extrapolate_values(std::size_t n, double r, double older_share, const double* now,
                                           const double* old, const double* older, double* __restrict out) {
  for (std::size_t m = 0; m < n; ++m) out[m] = now[m] + r * (now[m] - old[m]) - older_share * (old[m] - older[m]);
}

}  // namespace

Predictor::Predictor(FluidDomain& domain, const FluidSettings& settings)
    : domain_(domain),
      settings_(settings),
      convection_(domain.grid, domain.measures, domain.own, domain.local, domain.faces, domain.solved),
      viscous_(domain.measures, domain.own, domain.local, domain.faces, domain.solved),
      row_inertia_(domain.local.size(0)),
      row_made_(domain.local.size(0)) {
  const OpenShares* open = domain.measures.open();
  for (int d = 0; open && d < 3; ++d)
    for_each(domain.faces[d], [&](int i, int j, int k) {
      std::vector<double>& list = sliver_inverse_width_[d];
      const std::vector<std::ptrdiff_t>& faces = open->without_convection(d);
      if (list.size() < faces.size() && faces[list.size()] == open->theta().index(i, j, k))
        list.push_back(1 / domain.measures.axis(d).face_width(Int3{i, j, k}[d]));
    });
  if (!open) return;
  if (open->has_friction() || open->has_links()) list_friction(*open);
  for (const Sliver& s : open->slivers()) {
    const int d = s.component;
    const std::vector<std::ptrdiff_t>& faces = open->without_convection(d);
    const std::ptrdiff_t m = open->theta().index(s.face[0], s.face[1], s.face[2]);
    const auto place = std::lower_bound(faces.begin(), faces.end(), m);
    if (place == faces.end() || *place != m || domain.boundaries.state(d).data()[m] != FaceState::kSolved) continue;
    slivers_[d].push_back({int(place - faces.begin()),
                           s.face,
                           domain.measures.volume(d, s.face[0], s.face[1], s.face[2]),
                           s.drift,
                           s.velocity,
                           int(&s - open->slivers().data()),
                           domain.measures.axis(d).above_share_[s.face[d] - domain.measures.axis(d).lo],
                           {}});
    for (int q = 0; q < 6; ++q)
      if (s.share[q] > 0)
        slivers_[d].back().of.push_back({m + (q % 2 ? 1 : -1) * open->theta().stride(q / 2), s.share[q]});
  }
  int beyond = 0;
  for (int d = 0; d < 3; ++d) {
    std::vector<char> solved(open->theta().size(), 0);
    for_each(domain.faces[d], [&](int i, int j, int k) {
      const std::ptrdiff_t m = open->theta().index(i, j, k);
      solved[std::size_t(m)] = domain.boundaries.state(d).data()[m] == FaceState::kSolved;
    });
    for (const Following& s : slivers_[d])
      for (const auto& other : s.of) beyond = beyond || !solved[std::size_t(other.first)];
  }
  MPI_Allreduce(MPI_IN_PLACE, &beyond, 1, MPI_INT, MPI_MAX, domain.comm);
  slivers_look_beyond_ = beyond != 0;
  for (const WallPiece& p : open->pieces()) {
    const std::ptrdiff_t m = open->theta().index(p.face[0], p.face[1], p.face[2]);
    const double theta_f = open->theta_f()[p.component].data()[m];
    if (p.velocity != 0 && theta_f > 0 && !open->sliver(p.component, m) &&
        domain.boundaries.state(p.component).data()[m] == FaceState::kSolved)
      moving_walls_[p.component].push_back(
          {m, domain.measures.open_share_above(p.component, p.face[0], p.face[1], p.face[2]),
           p.conductance * p.velocity / theta_f, int(&p - open->pieces().data()), theta_f});
  }
}

Predictor::~Predictor() = default;

void Predictor::renew_walls() {
  const OpenShares& open = *domain_.measures.open();
  for (int d = 0; d < 3; ++d) {
    for (Following& f : slivers_[d])
      f.drift = open.slivers()[f.sliver].drift, f.velocity = open.slivers()[f.sliver].velocity;
    for (MovingWall& w : moving_walls_[d]) {
      const WallPiece& p = open.pieces()[w.piece];
      w.push = p.conductance * p.velocity / w.theta_f;
    }
  }
  convection_.renew_walls(open);
  viscous_.renew_walls();
}

void Predictor::extrapolate(const FluidState& state, const Step& step, FaceField<FineGrid>& u_tilde) const {
  for (int d = 0; d < 3; ++d)
    if (step.s2 != 0)
      extrapolate_values(state.u[d].size(), step.r + step.s1, step.s2, state.u[d].data(), state.u_old[d].data(),
                         state.u_older[d].data(), u_tilde[d].data());
    else
      extrapolate_values(state.u[d].size(), step.r, state.u[d].data(), state.u_old[d].data(), u_tilde[d].data());
  domain_.boundaries.apply(u_tilde);
}

/// Their friction mu K' i_f u_w V, and what links have of them.
void Predictor::add_moving_walls(const Property& mu, const FluidState& state, FaceField<FineGrid>& rhs) {
  for (int d = 0; d < 3; ++d)
    for (const MovingWall& w : moving_walls_[d]) {
      double viscosity = mu.number;
      if (mu.varies()) {
        const double *cell = mu.field().data() + w.face, below = cell[-state.p.stride(d)];
        viscosity = below + w.above * (*cell - below);
      }
      rhs[d].data()[w.face] += viscosity * w.push * state.inertia_share()[d].data()[w.face];
    }
  if (viscous_.cut()) viscous_.cut()->add_moving(mu, state.eps[0], rhs);
}

/// An inlet's pressure is the one that, with the momentum rho F u entering, balances pressure and momentum flux at the
/// first cell's centre, where the first solved volume begins: p_in A = p_cell A + rho (F u)_cell - rho (F u)_face.
void Predictor::measure_inlet_head(const FluidState& state, const FaceField<FineGrid>& u_tilde) {
  inlet_head_ = 0;
  if (settings_.convection == Convection::kNone) return;
  const double rho = settings_.density;
  for (int side = 0; side < 6; ++side) {
    if (!domain_.has(side, BoundaryKind::kInlet)) continue;
    domain_.boundaries.for_each_face(side, [&](int, int i, int j, int k) {
      if (domain_.boundaries.kind(side, i, j, k) != BoundaryKind::kInlet) return;
      const int d = direction(side);
      Int3 in{i, j, k};
      if (is_high(side)) --in[d];
      inlet_head_ +=
          convection_.convected_through(d, in[0], in[1], in[2], rho, state.eps_f, u_tilde, settings_.convection) -
          rho * (state.eps_f[d](i, j, k) * u_tilde[d](i, j, k)) * u_tilde[d](i, j, k) *
              domain_.measures.area(d, i, j, k);
    });
  }
}

/// On top of convection and viscosity in rhs: pressure, history, exchange; then u*. rhs may be u_next itself.
template <int d>
inline void Predictor::predict_component(const FluidState& state, const Step& step, const Interphase& exchange,
                                         FaceField<FineGrid>& rhs, FaceField<FineGrid>& u_next) {
  const double rho = settings_.density, imposed = state.imposed[d];
  const double c1 = rho * step.a1 / step.dt, c2 = rho * step.a2 / step.dt;
  const std::ptrdiff_t s = state.p.stride(d);
  double* __restrict A = row_inertia_.data();
  const FaceComponent<FineGrid>& inertia_share = state.inertia_share()[d];
  const OpenShares* open = domain_.measures.open();
  for_each_row(domain_.faces[d], domain_.measures.open_faces(d), state.p, [&](const Int3& x, std::ptrdiff_t m, int n) {
    const RowMeasure<d> row(domain_.measures, x);
    const auto share = along_row<d>(domain_.measures.axis(d).above_share_, x[d] - domain_.measures.axis(d).lo);
    const double *p = state.p.data() + m, *now = state.u[d].data() + m, *old = state.u_old[d].data() + m;
    const double *e1 = state.eps[1].data() + m, *e2 = state.eps[2].data() + m;
    double *o = rhs[d].data() + m, *next = u_next[d].data() + m;
    if (open) {
      const double* theta = open->theta_f()[d].data() + m;
#pragma GCC ivdep
      for (int i = 0; i < n; ++i)
        o[i] -= ((p[i] - p[i - s]) * row.inverse_width[i] + imposed) * (theta[i] * row.volume(i));
    } else {
#pragma GCC ivdep
      for (int i = 0; i < n; ++i) o[i] -= ((p[i] - p[i - s]) * row.inverse_width[i] + imposed) * row.volume(i);
    }
    if (const double* source = exchange.source_row(d, x[0], x[1], x[2], n, row_made_.data())) {
#pragma GCC ivdep
      for (int i = 0; i < n; ++i) o[i] += source[i] * row.volume(i);
    }
    inertia_.row(d, m, inertia_share.data() + m, exchange.beta_row(d, x[0], x[1], x[2], n, row_made_.data()), n, A);
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double V = row.volume(i);
      // eps on the faces at the levels before; wrong on prescribed faces, whose u* apply_normal() overwrites.
      const double f1 = e1[i - s] + share[i] * (e1[i] - e1[i - s]), f2 = e2[i - s] + share[i] * (e2[i] - e2[i - s]);
      const double sum = o[i] - (c1 * f1 * now[i] + c2 * f2 * old[i]) * V;
      o[i] = sum;
      next[i] = sum / (A[i] * V);
    }
    if (open) {
      const double* theta = open->theta_f()[d].data() + m;  // 0: closed
      for (int i = 0; i < n; ++i) next[i] = theta[i] > 0 ? next[i] : 0.0;
    }
    if (inertia_field_[d].size() > 0) std::copy_n(A, n, inertia_field_[d].data() + m);
  });
}

TWOGRID_VECTORISED void Predictor::predict_rows(const FluidState& state, const Step& step, const Interphase& exchange,
                                                FaceField<FineGrid>& rhs, FaceField<FineGrid>& u_next) {
  if (domain_.solved[0]) predict_component<0>(state, step, exchange, rhs, u_next);
  if (domain_.solved[1]) predict_component<1>(state, step, exchange, rhs, u_next);
  if (domain_.solved[2]) predict_component<2>(state, step, exchange, rhs, u_next);
}

/// Faces with friction at all.
void Predictor::list_friction(const OpenShares& open) {
  reset(friction_, domain_.local);
  for (int d = 0; d < 3; ++d)
    for_each(domain_.faces[d], [&](int i, int j, int k) {
      const std::ptrdiff_t m = friction_[d].index(i, j, k);
      const double of_walls = open.has_friction() ? open.friction()[d].data()[m] : 0.0;
      if (of_walls > 0 || (open.has_links() && open.sliver(d, m)))
        of_walls_[d].push_back({m, std::max(of_walls, 0.0), domain_.measures.open_share_above(d, i, j, k)});
    });
}

/// mu K' of faces: the friction of bodies' walls. Slivers, which no convection slows, have the drag 1/2 rho u^2 of their
/// open part besides, and so never go faster than the pressure of a cell could drive them.
void Predictor::set_wall_friction(const Property& mu, const FluidState& state, const FaceField<FineGrid>& u_tilde) {
  const OpenShares* open = domain_.measures.open();
  if (!open || !(open->has_friction() || open->has_links())) return;
  const double* cell = mu.varies() ? mu.field().data() : nullptr;
  for (int d = 0; d < 3; ++d) {
    const std::ptrdiff_t s = friction_[d].stride(d);
    for (const OfWalls& w : of_walls_[d]) {
      const double viscosity = cell ? cell[w.face - s] + w.share_above * (cell[w.face] - cell[w.face - s]) : mu.number;
      friction_[d].data()[w.face] = viscosity * w.per_viscosity;
    }
  }
  for (int d = 0; d < 3; ++d) {
    const std::vector<std::ptrdiff_t>& faces = open->without_convection(d);
    sliver_drag_[d].assign(faces.size(), 0.0);
    if (settings_.convection == Convection::kNone) continue;
    for (std::size_t q = 0; q < faces.size(); ++q) {
      const std::ptrdiff_t m = faces[q];
      if (!open->sliver(d, m)) continue;
      sliver_drag_[d][q] = 0.5 * settings_.density * std::abs(u_tilde[d].data()[m]) * sliver_inverse_width_[d][q];
      friction_[d].data()[m] += sliver_drag_[d][q];
    }
    for (const Following& s : slivers_[d]) {
      if (s.velocity == 0) continue;
      const std::ptrdiff_t m = faces[s.place];
      double& drag = sliver_drag_[d][s.place];
      const double still = drag;
      drag = 0.5 * settings_.density * std::abs(u_tilde[d].data()[m] - s.velocity) * sliver_inverse_width_[d][s.place];
      friction_[d].data()[m] += drag - still;
    }
    if (!domain_.blowing) continue;
    const double* rate = domain_.blowing->rate().data();
    for (const Following& s : slivers_[d]) {
      const std::ptrdiff_t m = faces[s.place], below = m - state.p.stride(d);
      const double held =
          settings_.density * (rate[below] + s.above * (rate[m] - rate[below])) / state.inertia_share()[d].data()[m];
      sliver_drag_[d][s.place] += held, friction_[d].data()[m] += held;
    }
  }
  inertia_.friction = &friction_;
}

/// Slivers flow by pressure and friction alone; what is carried to them and to closed faces is the bodies'.
void Predictor::lose_convection(FaceField<FineGrid>& rhs) {
  for (int d = 0; d < 3; ++d) {
    const std::vector<std::ptrdiff_t>& faces = domain_.measures.open()->without_convection(d);
    lost_convection_[d].resize(faces.size());
    for (std::size_t q = 0; q < faces.size(); ++q) lost_convection_[d][q] = std::exchange(rhs[d].data()[faces[q]], 0.0);
  }
}

/// The friction of slivers is against what they would have in shear along the wall, by the faces beside them.
void Predictor::drag_slivers_along(const FluidState& state, const Interphase& exchange, FaceField<FineGrid>& u_next) {
  const OpenShares* open = domain_.measures.open();
  if (!open || !open->has_links()) return;
  if (slivers_look_beyond_) domain_.fill(u_next);
  for (int d = 0; d < 3; ++d) {
    sliver_pull_[d].assign(open->without_convection(d).size(), 0.0);
    for (const Following& s : slivers_[d]) {
      const std::ptrdiff_t m = open->without_convection(d)[s.place];
      double along = s.drift, A, made;
      for (const auto& other : s.of) along += other.second * u_next[d].data()[other.first];
      inertia_.row(d, m, state.inertia_share()[d].data() + m,
                   exchange.beta_row(d, s.face[0], s.face[1], s.face[2], 1, &made), 1, &A);
      const double force = friction_[d].data()[m] * state.inertia_share()[d].data()[m] * along;
      u_next[d].data()[m] += force / A;
      // Of a wall that moves its own part counts with the friction.
      sliver_pull_[d][s.place] = s.velocity == 0 ? force * s.volume
                                                 : friction_[d].data()[m] * state.inertia_share()[d].data()[m] *
                                                       (along - s.velocity) * s.volume;
    }
  }
}

const Inertia& Predictor::predict(FluidState& state, const Step& step, const FluidProperties& properties,
                                  const Interphase& exchange, const FaceField<FineGrid>& u_tilde,
                                  FaceField<FineGrid>& u_next) {
  const double rho = settings_.density;
  const Property& mu = properties.viscosity;
  const bool viscous = mu.varies() || mu.number > 0, implicit = step.implicit_viscosity && viscous;
  if (implicit && inertia_field_[0].size() == 0) reset(rhs_, domain_.local), reset(inertia_field_, domain_.local);
  FaceField<FineGrid>& rhs = implicit ? rhs_ : u_next;
  for (int d = 0; d < 3; ++d)
    if (implicit)
      rhs[d].fill(0);
    else
      for_each_row(domain_.faces[d], domain_.measures.open_surroundings(d), rhs[d],
                   [&](const Int3&, std::ptrdiff_t m, int n) { std::fill_n(rhs[d].data() + m, n, 0.0); });
  convection_.add(rho, state.eps_f, u_tilde, settings_.convection, rhs);
  if (domain_.blowing && settings_.convection != Convection::kNone) domain_.blowing->add_momentum(rho, rhs);
  if (domain_.measures.open()) lose_convection(rhs);
  add_moving_walls(mu, state, rhs);
  measure_inlet_head(state, u_tilde);
  if (viscous && !step.implicit_viscosity) {
    viscous_.add(mu, state.eps[0], u_tilde, rhs);
    if (viscous_.cut()) viscous_.cut()->leave_moving_out(mu, state.eps[0]);
  }
  domain_.boundaries.set_outlet_pressure(u_tilde, rho);
  domain_.boundaries.apply_pressure(state.p);

  const bool gap = settings_.gap_friction;
  double friction = 0;  // of the walls of a one-cell gap, 12 mu/W^2
  for (int d = 0; gap && d < 3; ++d)
    if (!domain_.solved[d]) friction = 12 * mu.number / (domain_.grid.axis[d].length() * domain_.grid.axis[d].length());
  inertia_.per_eps = rho * step.a0 / step.dt + friction;
  set_wall_friction(mu, state, u_tilde);
  predict_rows(state, step, exchange, rhs, u_next);
  for (int d = 0; d < 3; ++d)
    if (!domain_.solved[d]) u_next[d].fill(0);
  domain_.boundaries.apply_normal(u_next);
  if (implicit) {
    if (!viscous_solver_)
      viscous_solver_ = std::make_unique<ViscousSolver>(domain_.comm, domain_.boundaries, domain_.measures, viscous_,
                                                        domain_.faces, domain_.local, domain_.face_halo);
    viscous_solver_->solve(mu, state.eps[0], inertia_field_, rhs_, u_next);
    if (viscous_.cut()) {
      domain_.fill(u_next);
      viscous_.cut()->leave_out(mu, state.eps[0], u_next);
      viscous_.cut()->leave_moving_out(mu, state.eps[0]);
    }
  }
  drag_slivers_along(state, exchange, u_next);
  return inertia_;
}

}  // namespace twogrid
