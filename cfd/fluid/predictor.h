// Steps (1) and (2) of the scheme (fluid_solver.h): u~ and u*.
#pragma once

#include <array>
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

  /// Walls' velocities have changed (OpenShares::set_blowing).
  void renew_walls();
  /// u~ with halo and ghosts.
  void extrapolate(const FluidState& state, const Step& step, FaceField<FineGrid>& u_tilde) const;
  /// u* on own faces, and A. Sets the ghosts of p^n. Collective where viscosity is implicit.
  const Inertia& predict(FluidState& state, const Step& step, const FluidProperties& properties,
                         const Interphase& exchange, const FaceField<FineGrid>& u_tilde, FaceField<FineGrid>& u_next);
  /// Of own inlet faces: momentum flux through the first cells' centres less that entering, N.
  double inlet_head() const { return inlet_head_; }
  /// What convection brought to the faces that take no part in it (OpenShares::without_convection, in its order), N.
  const std::array<std::vector<double>, 3>& lost_convection() const { return lost_convection_; }
  /// Null where nothing is cut; and its left_out() in the step.
  const CutLinks* cut_links() const { return viscous_.cut(); }
  const std::array<std::vector<double>, 3>& lost_stress() const {
    if (viscous_.cut()) return viscous_.cut()->left_out();
    return nothing_;
  }
  const std::array<std::vector<double>, 3>& exceeding() const {
    if (viscous_.cut()) return viscous_.cut()->exceeding();
    return nothing_;
  }
  /// Of the faces of OpenShares::without_convection: drag for want of convection (kg/(m3 s), per inertia share).
  const std::array<std::vector<double>, 3>& sliver_drag() const { return sliver_drag_; }
  /// Of the same faces: what drags them along against friction, N.
  const std::array<std::vector<double>, 3>& sliver_pull() const { return sliver_pull_; }

 private:
  void list_friction(const OpenShares& open);
  void add_moving_walls(const Property& mu, const FluidState& state, FaceField<FineGrid>& rhs);
  void set_wall_friction(const Property& mu, const FluidState& state, const FaceField<FineGrid>& u_tilde);
  void lose_convection(FaceField<FineGrid>& rhs);
  void drag_slivers_along(const FluidState& state, const Interphase& exchange, FaceField<FineGrid>& u_next);
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
  std::array<std::vector<double>, 3> lost_convection_, nothing_, sliver_drag_, sliver_pull_;
  std::array<std::vector<double>, 3> sliver_inverse_width_;  // of the same faces (1/m)
  struct Following {
    int place;  // in the list of faces that take no part in convection
    Int3 face;
    double volume, drift, velocity;                     // of the wall (Sliver)
    int sliver;                                         // its place in the list of them
    double above;                                       // share of the upper cell in its volume
    std::vector<std::pair<std::ptrdiff_t, double>> of;  // shares of other faces' velocities
  };
  std::array<std::vector<Following>, 3> slivers_;
  bool slivers_look_beyond_ = false;  // on any rank: at other faces than solved ones of its own
  struct OfWalls {
    std::ptrdiff_t face;
    double per_viscosity, share_above;  // K'; share of the upper cell in the face's viscosity
  };
  std::array<std::vector<OfWalls>, 3> of_walls_;  // own faces with friction
  /// Walls that move along themselves: their pieces' friction.
  struct MovingWall {
    std::ptrdiff_t face;
    double above;  // share of the upper cell in its viscosity
    double push;   // conductance u_w over theta_f (m2/s)
    int piece;     // of the surface
    double theta_f;
  };
  std::array<std::vector<MovingWall>, 3> moving_walls_;
  FaceField<FineGrid> friction_;  // mu K' and slivers' drag, only where bodies are
  std::vector<double> row_inertia_, row_made_;
  // Implicit viscosity; made when first needed.
  std::unique_ptr<ViscousSolver> viscous_solver_;
  FaceField<FineGrid> rhs_, inertia_field_;
};

}  // namespace twogrid
