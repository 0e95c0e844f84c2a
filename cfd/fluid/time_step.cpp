#include "cfd/fluid/time_step.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/measures/row_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

/// Share of the wanted Courant number for which a new step is chosen, and number of steps that could have been longer
/// before it grows.
constexpr double kChosenCfl = 0.8;
constexpr int kIdleSteps = 30;

}  // namespace

TimeStep::TimeStep(FluidDomain& domain, const FluidSettings& settings)
    : domain_(domain), settings_(settings), row_most_(domain.local.size(0)), row_sum_(domain.local.size(0)) {}

Step TimeStep::choose(FluidState& state, double left, double interval) {
  const double dt = allowed_dt(state, left, interval);
  return formula(state, dt);
}

Step TimeStep::shortened(FluidState& state, const Step& step, double cfl, double left, double interval) {
  const Step shorter =
      formula(state, left / std::ceil(left / (step.dt * std::min(0.75, kChosenCfl * settings_.cfl / cfl))));
  state.idle_steps = 0;
  refuse_steps_below(shorter.dt, interval);
  return shorter;
}

Step TimeStep::formula(const FluidState& state, double dt) const {
  Step s;
  s.dt = dt;
  s.implicit_viscosity = implicit_viscosity_;
  s.r = state.dt_previous > 0 ? dt / state.dt_previous : 0;
  s.a0 = (1 + 2 * s.r) / (1 + s.r);
  s.a1 = -(1 + s.r);
  s.a2 = s.r * s.r / (1 + s.r);
  if (settings_.convection == Convection::kCentral && state.dt_older > 0) {
    const double dt1 = state.dt_previous, dt2 = state.dt_older, share = 0.5 * dt * (dt + dt1) / (dt1 + dt2);
    s.s1 = share / dt1, s.s2 = share / dt2;
  }
  return s;
}

TWOGRID_VECTORISED void TimeStep::courant_rows(const FaceField<FineGrid>& u, double& rate, double& finite) const {
  const int whole = domain_.own.size(0);
  const std::ptrdiff_t sy = u[0].stride(1), sz = u[0].stride(2);
  std::fill_n(row_most_.data(), whole, 0.0), std::fill_n(row_sum_.data(), whole, 0.0);
  for_each_row(domain_.own, domain_.measures.open_cells(), u[0], [&](const Int3& q, std::ptrdiff_t m, int n) {
    const int first = q[0] - domain_.own.lo[0];
    double* __restrict most = row_most_.data() + first, * __restrict sum = row_sum_.data() + first;
    const double* ix = &domain_.measures.axis(0).inverse_width_[q[0] - domain_.measures.axis(0).lo];
    const double iy = domain_.measures.axis(1).inverse_width_[q[1] - domain_.measures.axis(1).lo];
    const double iz = domain_.measures.axis(2).inverse_width_[q[2] - domain_.measures.axis(2).lo];
    const double *ux = u[0].data() + m, *uy = u[1].data() + m, *uz = u[2].data() + m;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
      const double x = std::max(std::abs(ux[i]), std::abs(ux[i + 1])) * ix[i];
      const double y = std::max(std::abs(uy[i]), std::abs(uy[i + sy])) * iy;
      const double z = std::max(std::abs(uz[i]), std::abs(uz[i + sz])) * iz;
      most[i] = std::max(most[i], x + y + z);
      sum[i] += x + y + z;
    }
  });
  for (int i = 0; i < whole; ++i) rate = std::max(rate, row_most_[i]), finite += row_sum_[i];
}

double TimeStep::courant_rate(const FaceField<FineGrid>& u) const {
  double rate = 0, finite = 0;
  courant_rows(u, rate, finite);
  if (!std::isfinite(finite)) rate = INFINITY;
  MPI_Allreduce(MPI_IN_PLACE, &rate, 1, MPI_DOUBLE, MPI_MAX, domain_.comm);
  return rate;
}

double TimeStep::largest_viscous_step(const FluidState& state) const {
  // Extrapolated viscous terms: BDF2 is stable up to a step of 1/3 h^2/nu in one direction, 3/4 of it for div(tau); with
  // the extrapolation of central convection 1/5, and together with convection at the largest Courant number 0.12.
  double widest = 0;
  for (int d = 0; d < 3; ++d) {
    double h = INFINITY;
    for (int i = 0; i < domain_.grid.axis[d].n(); ++i) h = std::min(h, domain_.grid.axis[d].width(i));
    if (domain_.boundaries.component_solved(d) || domain_.grid.axis[d].n() > 1) widest += 1 / (h * h);
  }
  // Cut volumes may be half as large as what their links pass asks for.
  const OpenShares* open = domain_.measures.open();
  if (open && open->has_links()) widest *= 2;
  const double mu = state.largest_viscosity > 0 ? state.largest_viscosity : settings_.viscosity;
  return (settings_.convection == Convection::kCentral ? 0.12 : 0.2) * settings_.density / (mu * widest + 1e-300);
}

/// The step changes only when it must: backward differences with a varying step don't hand on momentum exactly, and
/// where the particles' noise decides both the step and the gas's acceleration, the errors would add up to a force. So
/// a new step is chosen below the limit, kept as long as the limit allows it, and grows only after many steps that
/// could have been longer.
double TimeStep::allowed_dt(FluidState& state, double left, double interval) {
  domain_.boundaries.apply_normal(state.u);
  double limit = settings_.dt > 0 ? settings_.dt : interval, chosen = limit;
  if (settings_.convection != Convection::kNone && settings_.dt == 0) {
    const double rate = courant_rate(state.u);
    if (rate > 0)
      limit = std::min(limit, settings_.cfl / rate), chosen = std::min(chosen, kChosenCfl * settings_.cfl / rate);
    if (state.dt_previous > 0)
      chosen = std::min(chosen, 2 * state.dt_previous);  // BDF2 is zero-stable up to a ratio of 2.41
  }
  const double viscous_limit = largest_viscous_step(state);
  implicit_viscosity_ = settings_.implicit_viscosity == Choice::kOn ||
                        (settings_.implicit_viscosity == Choice::kAuto && viscous_limit < chosen);
  if (!implicit_viscosity_ && settings_.dt == 0)
    limit = std::min(limit, viscous_limit), chosen = std::min(chosen, viscous_limit);
  refuse_steps_below(limit, interval);
  const double wanted = left / std::ceil(left / std::min(chosen, left) - 1e-9);
  if (state.dt_previous > 0 && settings_.dt == 0 && state.dt_previous <= limit * (1 + 1e-9)) {
    const double parts = std::round(interval / state.dt_previous), steps = left / state.dt_previous;
    const bool fits = steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-6;
    state.idle_steps = parts > 1 && chosen > 0.999 * interval / (parts - 1) ? state.idle_steps + 1 : 0;
    if (fits && (state.idle_steps < kIdleSteps || wanted < state.dt_previous)) return left / std::round(steps);
  }
  state.idle_steps = 0;
  return wanted;
}

/// An interval of more fluid steps than this is a mistake in the script, and would seem to hang.
void TimeStep::refuse_steps_below(double limit, double interval) const {
  if (limit * kMostSteps >= interval) return;
  std::ostringstream text;
  text << "a coupling interval of " << interval << " s would need " << interval / limit << " fluid steps of " << limit
       << " s, wanted: at most " << kMostSteps << "; ";
  if (settings_.dt > 0 && limit >= settings_.dt)
    text << "raise 'dt' (" << settings_.dt << " s), or lower 'every' or the DEM timestep";
  else
    text << "look for an inlet or particles too fast and for fine cells too small ('fine', 'stretch'); else lower "
            "'every' or the DEM timestep, or raise 'cfl' ("
         << settings_.cfl << ")" << (settings_.implicit_viscosity == Choice::kOff ? ", or say 'implicit auto'" : "");
  throw std::runtime_error(text.str());
}

}  // namespace twogrid
