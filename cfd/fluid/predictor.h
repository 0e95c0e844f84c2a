// Steps (1) and (2) of the scheme (fluid_solver.h): u~ and u*.
#pragma once

#include <memory>
#include <vector>

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid/inertia.h"
#include "cfd/fluid/properties.h"
#include "cfd/fluid/time_step.h"
#include "cfd/fluid_settings.h"
#include "cfd/momentum/convection.h"
#include "cfd/momentum/viscous_stress.h"

namespace twogrid {

class ViscousSolver;

class Predictor {
 public:
  Predictor(FluidDomain& domain, const FluidSettings& settings);
  ~Predictor();

  /// u~ with halo and ghosts.
  void extrapolate(const FluidState& state, const Step& step, FaceField<FineGrid>& u_tilde) const;
  /// u* on own faces, and A. Sets the ghosts of p^n. Collective where viscosity is implicit.
  const Inertia& predict(FluidState& state, const Step& step, const FluidProperties& properties,
                         const Interphase& exchange, const FaceField<FineGrid>& u_tilde, FaceField<FineGrid>& u_next);
  /// Of own inlet faces: momentum flux through the first cells' centres less that entering, N.
  double inlet_head() const { return inlet_head_; }

 private:
  void set_wall_friction(const Property& mu);
  void measure_inlet_head(const FluidState& state, const FaceField<FineGrid>& u_tilde);
  void predict_rows(const FluidState& state, const Step& step, const Interphase& exchange, FaceField<FineGrid>& rhs,
                    FaceField<FineGrid>& u_next);
  template <int d>
  void predict_component(const FluidState& state, const Step& step, const Interphase& exchange,
                         FaceField<FineGrid>& rhs, FaceField<FineGrid>& u_next);

  FluidDomain& domain_;
  const FluidSettings& settings_;
  ConvectionTerm convection_;
  ViscousTerm viscous_;
  Inertia inertia_;
  double inlet_head_ = 0;
  FaceField<FineGrid> friction_;  // mu K', only where bodies' walls have friction
  std::vector<double> row_inertia_, row_made_;
  // Implicit viscosity; made when first needed.
  std::unique_ptr<ViscousSolver> viscous_solver_;
  FaceField<FineGrid> rhs_, inertia_field_;
};

}  // namespace twogrid
