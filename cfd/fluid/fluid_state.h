// The state of the fluid: all that one step hands to the next, and all that others read after it. What is not here is
// made anew in every step. A copy of the struct is a checkpoint in memory; for_each_entry() walks by name what one
// interval leaves to the next: means over an interval are read at its end only, and are none of it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/grid/field.h"
#include "cfd/grid/state_entries.h"

namespace twogrid {

struct FluidState {
  using Levels = std::array<CellField<FineGrid>, 3>;
  /// d(eps)/dt - q of a step from the levels of eps.
  struct Rate {
    double b0 = 0, b1 = 0, b2 = 0, excess = 0;  // 1/s; excess: q of a closed domain
    double at(const Levels& eps, std::ptrdiff_t m, double open_share) const {
      return b0 * eps[0].data()[m] + b1 * eps[1].data()[m] + b2 * eps[2].data()[m] - excess * open_share;
    }
  };

  double time = 0;                 // t^n (s)
  double dt_previous = 0;          // t^n - t^{n-1} (s); 0: no history
  int idle_steps = 0;              // steps in a row that could have been longer
  double dt_older = 0;             // t^{n-1} - t^{n-2} (s); 0: not known
  FaceField<FineGrid> u, u_old;    // u^n, u^{n-1} (m/s), with halo and ghosts
  FaceField<FineGrid> u_older;     // u^{n-2}; only with central convection
  CellField<FineGrid> p;           // dynamic pressure (Pa), likewise
  Levels eps;                      // eps^n, eps^{n-1}, eps^{n-2}; with open shares theta eps (open_shares.h)
  Vec3 imposed{0, 0, 0};           // G (Pa/m)
  double largest_viscosity = 0;    // of the last step, where it varies: bounds the next (Pa s); 0: not known
  CellField<FineGrid> phi;         // change of p in the last step: the pressure solver's next first guess (Pa)
  std::vector<ModelField> fields;  // of models (fluid_model.h)
  CellField<FineGrid> response;    // potential answering a unit mean gradient: first guess too; only with a flow rate
  // Read after a step.
  FaceField<FineGrid> eps_f;     // eps^n on faces: flux share, and inertia share where i_f is not in use
  FaceField<FineGrid> i_f;       // inertia share; only with open shares
  CellField<FineGrid> eps_open;  // eps^n of the open space; the same
  Rate rate;                     // of the last step
  // Read at the end of an interval.
  bool one_step = true;             // the last interval was one step: its mean of u is u
  FaceField<FineGrid> mean_u;       // over the last interval, unless one_step
  FaceField<FineGrid> mean_grad_p;  // the same (Pa/m); only if wanted

  const FaceField<FineGrid>& inertia_share() const { return i_f[0].size() > 0 ? i_f : eps_f; }

  /// Calls f(name, entry) for every entry, in an order that is always the same; entry: double&, int&, bool& or
  /// Array3<double>& (of size 0 where not in use). S: FluidState or const FluidState.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("time", s.time), f("dt_previous", s.dt_previous), f("dt_older", s.dt_older), f("idle_steps", s.idle_steps);
    show_components(s.u, {"u_x", "u_y", "u_z"}, f), show_components(s.u_old, {"u_old_x", "u_old_y", "u_old_z"}, f);
    show_components(s.u_older, {"u_older_x", "u_older_y", "u_older_z"}, f);
    show_array("p", s.p, f);
    show_components(s.eps, {"eps_0", "eps_1", "eps_2"}, f);
    f("imposed_x", s.imposed[0]), f("imposed_y", s.imposed[1]), f("imposed_z", s.imposed[2]);
    f("largest_viscosity", s.largest_viscosity);
    for (auto& field : s.fields) show_array(field.name.c_str(), field.values, f);
    show_array("phi", s.phi, f), show_array("response", s.response, f);
    show_components(s.eps_f, {"eps_f_x", "eps_f_y", "eps_f_z"}, f);
    show_components(s.i_f, {"i_f_x", "i_f_y", "i_f_z"}, f), show_array("eps_open", s.eps_open, f);
    f("rate_0", s.rate.b0), f("rate_1", s.rate.b1), f("rate_2", s.rate.b2), f("rate_excess", s.rate.excess);
  }
};

}  // namespace twogrid
