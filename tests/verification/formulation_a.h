// Formulation A as it runs: the fluid sees all of grad p, and the particles' pressure force comes back as a source. As
// the coupling does it (coupling/forces/undisturbed_force.h, coupling/forces/pressure_force.h), with particles that read at every
// face by itself: force on them per volume beta (u - v) + eps_s (R + D/eps), D = beta (u - v), R from the interval
// before. So the tests that use this see what a user's run has, its order in time, too: the first in the interval.
#pragma once

#include "coupling/forces/undisturbed_force.h"
#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"

namespace twogrid {

class FormulationA {
 public:
  explicit FormulationA(CfdBox& box) : box_(box), undisturbed_(box.comm(), *box.fluid, r_), eps_f_(box.face_field()) {
    box.fluid->keep_pressure_gradient();
    for (auto* x : {&reaction_, &exchange_}) x->source = x->beta = box.face_field();
  }

  /// The interval to come, with eps at its end: beta (kg/(m3 s)) and beta v (N/m3) of the particles, fields without
  /// values where there is no drag; what else drives the fluid (N/m3), likewise.
  const FieldExchange& exchange(const FaceField<FineGrid>& beta, const FaceField<FineGrid>& beta_v,
                                const FaceField<FineGrid>& other) {
    box_.fluid->measures().face_mean(box_.eps_end, eps_f_);
    for (int d = 0; d < 3; ++d)
      for_each(box_.faces(d), [&](int i, int j, int k) {
        const double e = eps_f_[d](i, j, k);
        double source = -(1 - e) * undisturbed_.field()[d](i, j, k);
        if (beta[d].size() > 0) {
          reaction_.beta[d](i, j, k) = exchange_.beta[d](i, j, k) = beta[d](i, j, k) / e;
          if (beta_v[d].size() > 0) source += beta_v[d](i, j, k) / e;
        }
        reaction_.source[d](i, j, k) = source;
        exchange_.source[d](i, j, k) = source + (other[d].size() > 0 ? other[d](i, j, k) : 0.0);
      });
    return exchange_;
  }
  /// The interval is over.
  void read() { undisturbed_.update(*box_.fluid, box_.eps_end, reaction_, kHeavy * box_.fluid->density()); }

 private:
  static constexpr double kHeavy = 1000;  // particles in a gas

  CfdBox& box_;
  FaceField<FineGrid> r_;
  UndisturbedForce undisturbed_;
  FaceField<FineGrid> eps_f_;
  FieldExchange reaction_, exchange_;  // without and with what drives the fluid beside the particles
};

}  // namespace twogrid
