// Steps (3) and (4) of the scheme (fluid_solver.h): phi, and u^{n+1}.
#pragma once

#include <memory>
#include <vector>

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid/inertia.h"
#include "cfd/fluid/time_step.h"
#include "cfd/fluid_settings.h"
#include "cfd/grid/property.h"

namespace twogrid {

class PressureSolver;

class Projection {
 public:
  Projection(FluidDomain& domain, const FluidSettings& settings);
  ~Projection();

  /// u_next: u*, whose halo is filled. On return phi and the step's rate are in the state, and the faces' conductance
  /// eps/A area/distance (halo of one) in the given field. Returns the solver's iterations. Collective.
  int project(FluidState& state, const Step& step, const Inertia& inertia, const Interphase& exchange,
              FaceField<FineGrid>& u_next, FaceField<FineGrid>& conductance);
  /// u_next becomes u^{n+1}, with halo and ghosts. Collective.
  void correct(FluidState& state, const FaceField<FineGrid>& conductance, FaceField<FineGrid>& u_next) const;
  /// The rotational part of p^{n+1}, after all that the fluid felt (p^n + phi) has been measured; steps with implicit
  /// viscosity. Collective.
  void rotate_pressure(const Property& mu, FluidState& state) const;
  /// Largest |eps u*| of the last project() (m/s).
  double velocity_scale() const { return velocity_scale_; }
  /// With the operator of the last project().
  PressureSolver& solver() { return *pressure_solver_; }

 private:
  void set_conductance(const FluidState& state, const Inertia& inertia, const Interphase& exchange,
                       FaceField<FineGrid>& conductance);
  void conductance_rows(const FluidState& state, const Inertia& inertia, const Interphase& exchange,
                        FaceField<FineGrid>& conductance);
  template <int d>
  void conductance_component(const FluidState& state, const Inertia& inertia, const Interphase& exchange,
                             FaceField<FineGrid>& conductance);
  void missing_continuity(const FluidState& state, const FaceField<FineGrid>& u_next, double& scale, double& sum);
  void balance_outlets(double sum, const FaceField<FineGrid>& conductance, CellField<FineGrid>& phi) const;
  void centre_open_cells(CellField<FineGrid>& phi) const;
  void correct_rows(const FluidState& state, const FaceField<FineGrid>& conductance, FaceField<FineGrid>& u_next) const;
  template <int d>
  void correct_component(const FluidState& state, const FaceField<FineGrid>& conductance,
                         FaceField<FineGrid>& u_next) const;

  FluidDomain& domain_;
  std::unique_ptr<PressureSolver> pressure_solver_;
  const double density_;
  double velocity_scale_ = 0;
  CellField<FineGrid> imbalance_;
  CellField<FineGrid> divergence_;     // implicit viscosity: imbalance_ before the pressure solver uses it
  std::vector<double> row_a_, row_b_;  // one value a cell of a row
};

}  // namespace twogrid
