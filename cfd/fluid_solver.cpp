#include "cfd/fluid_solver.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/fluid/initial_flow.h"
#include "cfd/fluid/void_levels.h"

namespace twogrid {

namespace {

const FluidSettings& checked(const FluidSettings& s, const FineGrid& grid) {
  s.check(grid);
  s.check_flow(grid);
  return s;
}

void copy(const Array3<double>& from, Array3<double>& to, const Box& box) {
  for_each(box, [&](int i, int j, int k) { to(i, j, k) = from(i, j, k); });
}

/// Zero on faces that bodies close, where steps leave it so.
void close_faces(const FluidDomain& domain, FaceField<FineGrid>& u) {
  const OpenShares* open = domain.measures.open();
  for (int d = 0; open && d < 3; ++d) open->close(d, u[d].data());
}

}  // namespace

FluidSolver::FluidSolver(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings)
    : settings_(checked(settings, grid)),
      domain_(comm, grid, layout, settings_),
      time_step_(domain_, settings_),
      predictor_(domain_, settings_),
      projection_(domain_, settings_),
      flow_rate_(domain_, settings_),
      means_(domain_),
      monitors_(domain_, settings_),
      body_forces_(domain_, predictor_.cut_links()) {
  for (auto* f : {&state_.u, &state_.u_old, &u_tilde_, &u_next_, &state_.eps_f}) reset(*f, domain_.local);
  if (settings_.convection == Convection::kCentral) reset(state_.u_older, domain_.local);
  for (auto& level : state_.eps) level.reset(domain_.local, 1.0);
  for (auto* c : {&state_.p, &state_.phi}) c->reset(domain_.local);
  if (domain_.measures.open()) reset(state_.i_f, domain_.local), state_.eps_open.reset(domain_.local, 1.0);
  state_.imposed = settings_.pressure_gradient;
  properties_.viscosity.number = settings_.viscosity;
  if (settings_.wall_stress && !settings_.bodies.empty())
    wall_stress_ = std::make_unique<WallStress>(domain_, settings_.bodies, state_, properties_.viscosity);
  update_velocities();
}

/// Of sides and walls, as they are now.
void FluidSolver::update_velocities() {
  if (!domain_.update_velocities()) return;
  predictor_.renew_walls();
  body_forces_.renew_walls();
  if (wall_stress_) wall_stress_->renew_walls(domain_.blowing->velocity());
}

FluidReport FluidSolver::advance(double interval, const VoidFractionInTime& eps, const Interphase& exchange) {
  FluidReport report;
  if (exchange.replaced) replace_fluid(domain_, *eps.begin, exchange.same_flux, state_);
  means_.begin(state_);
  body_forces_.begin();
  if (state_.largest_viscosity == 0) update_properties(state_.u);  // for the first step's length
  double done = 0;
  while (done < interval * (1 - 1e-12)) {
    update_velocities();
    Step step = time_step_.choose(state_, interval - done, interval);
    for (;;) {
      next_level(domain_, eps, std::min(1.0, (done + step.dt) / interval), interval, state_);
      predictor_.extrapolate(state_, step, u_tilde_);
      update_properties(u_tilde_);
      const Inertia& A = predictor_.predict(state_, step, properties_, exchange, u_tilde_, u_next_);
      report.pressure_iterations += projection_.project(state_, step, A, exchange, u_next_, conductance_);
      projection_.correct(state_, conductance_, u_next_);
      flow_rate_.hold(state_, exchange, conductance_, projection_.solver(), u_next_);
      const double cfl = time_step_.courant_rate(u_next_) * step.dt;
      check_finite(cfl, step);
      // A sudden inflow may break the limit only after the projection has seen it: take the step again, smaller.
      if (cfl <= settings_.cfl || settings_.convection == Convection::kNone || settings_.dt > 0) {
        report.cfl = std::max(report.cfl, cfl);
        break;
      }
      previous_level(state_);
      step = time_step_.shortened(state_, step, cfl, interval - done, interval);
    }
    accept(step);
    means_.add(step.dt / interval, state_);
    monitors_.measure(state_, predictor_.inlet_head(), projection_.velocity_scale(), step.dt / interval, report);
    if (body_forces_.any())
      body_forces_.add(step.dt / interval, state_, properties_.viscosity, predictor_.lost_convection(),
                       predictor_.lost_stress(), predictor_.exceeding(), predictor_.sliver_drag(),
                       predictor_.sliver_pull());
    if (domain_.blowing)
      body_forces_.add_blown(step.dt / interval, settings_.convection == Convection::kNone ? 0 : settings_.density);
    if (step.implicit_viscosity) projection_.rotate_pressure(properties_.viscosity, state_);
    for (auto& model : models_) model->step(domain_, step, state_);
    done += step.dt;
    if (after_step_ && done < interval * (1 - 1e-12)) after_step_(report.steps, done / interval);
  }
  body_forces_.end();
  return report;
}

void FluidSolver::add_model(std::unique_ptr<FluidModel> model) {
  models_.push_back(std::move(model));
  state_.largest_viscosity = 0;
}

int FluidSolver::add_field(const std::string& name, const std::string& unit, double value) {
  state_.fields.push_back({name, unit, {}});
  state_.fields.back().values.reset(domain_.local, value);
  return int(state_.fields.size()) - 1;
}

void FluidSolver::update_properties(const FaceField<FineGrid>& u) {
  properties_.viscosity.number = settings_.viscosity;
  for (auto& model : models_) model->properties(domain_, state_, u, properties_);
  if (!properties_.viscosity.varies()) return;
  if (settings_.gap_friction)
    throw std::invalid_argument(
        "'gap friction on' together with a model of the fluid's viscosity; wanted: 'gap friction off', for its walls "
        "need the viscosity as one number");
  complete(domain_, state_, properties_);
}

void FluidSolver::check_finite(double cfl, const Step& step) const {
  if (std::isfinite(cfl)) return;
  std::ostringstream text;
  text << "the fluid's velocity is not finite at t = " << state_.time + step.dt << " s (fluid step " << step.dt
       << " s); wanted: finite values; lower 'cfl' (" << settings_.cfl << ") or 'every', or coarsen 'fine'";
  throw std::runtime_error(text.str());
}

/// u_next_ and p + phi become the state.
void FluidSolver::accept(const Step& step) {
  for_each(domain_.own, [&](int i, int j, int k) { state_.p(i, j, k) += state_.phi(i, j, k); });
  for (int d = 0; d < 3; ++d) {
    if (settings_.convection == Convection::kCentral) state_.u_older[d].swap(state_.u_old[d]);
    state_.u_old[d].swap(state_.u[d]), state_.u[d].swap(u_next_[d]);
  }
  domain_.fill(state_.p);
  domain_.boundaries.apply_pressure(state_.p);
  state_.time += step.dt;
  state_.dt_older = state_.dt_previous;
  state_.dt_previous = step.dt;
}

FluidReport FluidSolver::advance_and_check(double interval, const VoidFractionInTime& eps, const Interphase& exchange) {
  const bool kept = means_.keep_pressure_gradient;
  means_.keep_pressure_gradient = true;
  FluidState begin = state_;
  FluidReport report = advance(interval, eps, exchange);
  FluidState end = std::move(state_);
  const std::vector<BodyForce> forces = body_forces_.forces();
  state_ = std::move(begin);
  const double dt = settings_.dt;
  settings_.dt = 0.5 * interval / report.steps;
  advance(interval, eps, exchange);
  settings_.dt = dt;
  report.step_error = monitors_.difference(state_, end);
  state_ = std::move(end);
  body_forces_.restore(forces);
  means_.keep_pressure_gradient = kept;
  if (!kept) state_.mean_grad_p = {};
  return report;
}

void FluidSolver::start(const CellField<FineGrid>& eps) {
  state_.time = 0;
  state_.dt_previous = state_.dt_older = 0;
  copy(eps, state_.eps[0], domain_.local);
  take_open_part(domain_, state_.eps[0], &state_.eps_open);
  set_face_eps(domain_, state_);
  state_.eps[1] = state_.eps[0];
  state_.p.fill(initial_pressure(settings_));
  state_.phi.fill(0);
  set_initial_velocity(domain_, settings_, state_.u);
  close_faces(domain_, state_.u);
  update_velocities();
  domain_.fill(state_.u);
  make_continuous();
  state_.u_old = state_.u;
  state_.one_step = true;
  for (auto& g : state_.mean_grad_p) g.fill(0);
}

/// Projects the initial u onto one that satisfies continuity with eps at rest: a run that starts with its inlets open
/// then starts without the infinite pressure of an impulsive start.
void FluidSolver::make_continuous() {
  for (int d = 0; d < 3; ++d) u_next_[d] = state_.u[d];
  projection_.project(state_, Step{1, 0, 1, -1, 0}, Inertia{settings_.density}, Interphase{}, u_next_, conductance_);
  projection_.correct(state_, conductance_, u_next_);
  for (int d = 0; d < 3; ++d) state_.u[d].swap(u_next_[d]);
}

void FluidSolver::restored() {
  update_velocities();
}

void FluidSolver::set_state(double time, const FaceField<FineGrid>& u, const CellField<FineGrid>& p,
                            const CellField<FineGrid>& eps, double dt_previous, const FaceField<FineGrid>& u_previous,
                            const CellField<FineGrid>& eps_previous) {
  state_.time = time;
  state_.dt_previous = dt_previous, state_.dt_older = 0;
  update_velocities();
  for (int d = 0; d < 3; ++d)
    copy(u[d], state_.u[d], domain_.faces[d]), copy(u_previous[d], state_.u_old[d], domain_.faces[d]);
  close_faces(domain_, state_.u), close_faces(domain_, state_.u_old);
  domain_.fill(state_.u);
  domain_.fill(state_.u_old);
  copy(p, state_.p, domain_.own);
  domain_.fill(state_.p);
  copy(eps, state_.eps[0], domain_.local);
  copy(eps_previous, state_.eps[1], domain_.local);
  take_open_part(domain_, state_.eps[0], &state_.eps_open);
  take_open_part(domain_, state_.eps[1], nullptr);
  set_face_eps(domain_, state_);
}

}  // namespace twogrid
