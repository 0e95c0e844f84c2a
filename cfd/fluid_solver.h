// The volume-averaged Navier-Stokes equations on a staggered tensor-product grid.
//
//   mass       d(eps)/dt + div(eps u) = q
//   momentum   rho [ d(eps u)/dt + div(eps u u) ] = -(grad p + G) + div(eps tau) + source - beta u
//
// One step t^n -> t^{n+1} = t^n + dt (BDF2 with variable step; r = dt/dt_previous,
// a0 = (1+2r)/(1+r), a1 = -(1+r), a2 = r^2/(1+r); the first step is backward Euler):
//   (1) extrapolate  u~ = (1+r) u^n - r u^{n-1},  F~ = eps^{n+1} u~ on faces
//                    (central convection: + dt (dt + dt_1)/2 times the second divided difference of u^n, u^{n-1},
//                    u^{n-2}; with constant steps u~ = 5/2 u^n - 2 u^{n-1} + 1/2 u^{n-2}. Without it any central scheme
//                    that keeps energy grows, by 0.7 % a step at a Courant number of 0.3; with it none does up to 0.67)
//                    then, where models say so, properties (mu) as fields from u^n and u~
//   (2) predict      A u* = -rho/dt (a1 eps^n u^n + a2 eps^{n-1} u^{n-1}) - rho div(F~ u~) + div(eps tau(u~))
//                           - (grad p^n + G) + source,        A = a0 rho eps^{n+1}/dt + beta (+ gap and wall friction)
//                    (implicit viscosity: tau(u*) on the left, conjugate gradients)
//   (3) project      div( eps/A grad phi ) = div(eps u*) + d(eps)/dt - q,   d(eps)/dt by the same BDF2 formula
//                    (first guess: r phi of the step before)
//   (4) correct      u^{n+1} = u* - grad phi/A,   p^{n+1} = p^n + phi
//                    (- 4/3 mu (div(eps u*) + d(eps)/dt - q) when viscosity is implicit: the rotational form of
//                    Guermond & Shen (2004))
//   (5) models' own fields, by the fluxes of this step
// All at t^{n+1}; eps on faces is the volume-weighted mean of the cells'; prescribed faces keep their value.
#pragma once

#include <mpi.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cfd/bodies/body_forces.h"
#include "cfd/bodies/wall_stress.h"
#include "cfd/fluid/domain.h"
#include "cfd/fluid/flow_rate.h"
#include "cfd/fluid/fluid.h"
#include "cfd/fluid/fluid_model.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid/interval_means.h"
#include "cfd/fluid/monitors.h"
#include "cfd/fluid/predictor.h"
#include "cfd/fluid/projection.h"
#include "cfd/fluid/properties.h"
#include "cfd/fluid/time_step.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

class FluidSolver : public Fluid {
 public:
  /// Collective. The settings are copied. Throws std::invalid_argument with a sentence when they can't be right.
  FluidSolver(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings);

  const FineGrid& grid() const override { return domain_.grid; }
  const Layout& layout() const override { return domain_.layout; }
  double density() const override { return settings_.density; }
  double viscosity() const override { return settings_.viscosity; }
  const Array3<FaceState>& face_state(int d) const override { return domain_.boundaries.state(d); }
  const FaceField<FineGrid>& velocity() const override { return state_.u; }
  const FaceField<FineGrid>& mean_velocity() const override { return state_.one_step ? state_.u : state_.mean_u; }
  const FaceField<FineGrid>& mean_pressure_gradient() const override { return state_.mean_grad_p; }
  void keep_pressure_gradient() override { means_.keep_pressure_gradient = true; }
  const CellField<FineGrid>& pressure() const override { return state_.p; }
  const CellField<FineGrid>& void_fraction() const override {
    if (domain_.measures.open()) return state_.eps_open;
    return state_.eps[0];
  }
  /// What bodies blow into the fluid; null where nothing does.
  const Blowing* blowing() const { return domain_.blowing.get(); }
  /// What is said of the bodies in the grid; null without bodies.
  const CutReport* cut() const { return domain_.cut(); }
  const OpenShares* open_shares() const override { return domain_.measures.open(); }
  double time() const override { return state_.time; }
  bool knows_last_step() const override { return true; }
  double flux(int d, int i, int j, int k) const override { return state_.eps_f[d](i, j, k) * state_.u[d](i, j, k); }
  double void_fraction_rate(int i, int j, int k) const override {
    const double rate = state_.rate.at(state_.eps, state_.p.index(i, j, k), domain_.measures.open_share(i, j, k));
    return domain_.blowing ? rate - domain_.blowing->rate()(i, j, k) : rate;
  }

  void start(const CellField<FineGrid>& eps) override;
  FluidReport advance(double interval, const VoidFractionInTime& eps, const Interphase& exchange) override;
  FluidReport advance_and_check(double interval, const VoidFractionInTime& eps, const Interphase& exchange) override;
  void limit_courant_number(double cfl) override {
    settings_.cfl = std::min(cfl, FluidSettings::largest_cfl(settings_.convection));
  }
  /// Most fluid steps of an interval: advance throws std::runtime_error, on all ranks, when it would need more.
  static constexpr int kMostSteps = TimeStep::kMostSteps;
  /// after(steps, share): called on all ranks after every fluid step of an interval but its last, with the number of
  /// steps done and the share of the interval behind them. It may throw, on all ranks alike.
  void watch_steps(std::function<void(int, double)> after) { after_step_ = std::move(after); }

  /// From the next step on the model is part of the step. Particles go on to see density() and viscosity(), whatever it
  /// does to properties.
  void add_model(std::unique_ptr<FluidModel> model);
  /// A field of the state for a model, of the same value everywhere, halo of void_fraction(). Returns its place in
  /// FluidState::fields.
  int add_field(const std::string& name, const std::string& unit, double value);
  const std::vector<ModelField>& model_fields() const override { return state_.fields; }
  /// Forces on the bodies (FluidSettings::bodies), means over the last interval; empty where there are none.
  const std::vector<BodyForce>& body_forces() const override { return body_forces_.forces(); }
  WallStress* wall_stress() const override { return wall_stress_.get(); }
  /// What another model gives it, such as a heat source of the particles.
  CellField<FineGrid>& model_field(int place) { return state_.fields[place].values; }

  /// Settings that may change between runs (inlet values, tolerances); the grid and the kinds of boundary may not.
  FluidSettings& settings() { return settings_; }
  const FluidState& state() const { return state_; }
  const Boundaries& boundaries() const { return domain_.boundaries; }
  const GridMeasures& measures() const { return domain_.measures; }

  /// To be filled by a checkpoint's values, halos included; restored() then makes what follows from it. Collective.
  FluidState& state_to_restore() { return state_; }
  void restored();

  /// For verification: the state at two levels, t^n = time and t^{n-1} = time - dt_previous. The fields cover own
  /// values and are copied; halos are filled here. Collective.
  void set_state(double time, const FaceField<FineGrid>& u, const CellField<FineGrid>& p,
                 const CellField<FineGrid>& eps, double dt_previous, const FaceField<FineGrid>& u_previous,
                 const CellField<FineGrid>& eps_previous);
  /// rho sum of eps u V over solved faces: momentum of the fluid (N s). Collective.
  Vec3 total_momentum() const { return monitors_.total_momentum(state_); }
  /// Momentum that BDF2 has still to hand on: rho/2 ((eps u V)^n - (eps u V)^{n-1}); total + pending changes by exactly
  /// force times dt when the step is constant. Collective.
  Vec3 pending_momentum() const { return monitors_.pending_momentum(state_); }

 private:
  void make_continuous();
  void update_velocities();
  void update_properties(const FaceField<FineGrid>& u);
  void check_finite(double cfl, const Step& step) const;
  void accept(const Step& step);

  FluidSettings settings_;
  FluidDomain domain_;
  FluidState state_;
  FluidProperties properties_;
  std::vector<std::unique_ptr<FluidModel>> models_;

  TimeStep time_step_;
  Predictor predictor_;
  Projection projection_;
  FlowRate flow_rate_;
  IntervalMeans means_;
  Monitors monitors_;
  BodyForces body_forces_;
  std::unique_ptr<WallStress> wall_stress_;  // only if wanted

  // Work. Fields that are never needed at the same time share memory. Doubles a cell, H: on own cells and the halo, else
  // on own cells:
  //   H  u 3, u_old 3 (central convection: u_older 3), u_next_ 3, u_tilde_ 3, eps_f 3, eps 3, p 1, phi 1: together 20, and 3 bytes of face states
  //      imbalance 1; pressure solver: solution 1, conjugate gradients 3; with it 36 bytes a cell of each multigrid
  //      level and its halo of one (single precision; all levels: 1.4 to 1.7 times the finest)
  //      only when asked for: mean_u 3 (intervals of several steps), mean_grad_p 3 (formulation A, accuracy)
  //   H  in the coupling: VoidHistory 4; formulation A: Residual 3
  //      in the coupling: source 3 where complete_drag() is at work; else values of the particle grid's cells only
  FaceField<FineGrid> u_next_;                   // right-hand side of the predictor, u*, u^{n+1}
  FaceField<FineGrid> u_tilde_;                  // u~, until the predictor is done
  FaceField<FineGrid>& conductance_ = u_tilde_;  // from then on
  std::function<void(int, double)> after_step_;
};

}  // namespace twogrid
