// What the particles do to the fluid in an interval: the reaction to their impulses and the implicit drag, on faces.
//
// Momentum of particle p in the interval D: impulse I_p (received by the forces of the DEM steps) and kick K_p.
//   react     V_f source_f = sum_p w_pf (b'_p u_ref - I_p/D),   V_f beta_f = sum_p w_pf b'_p
//   kick      K_p = b'_p (READ(mean u) - u_ref) D (gather_fluid.h), so that
//             sum_p (I_p + K_p) + sum_f V_f (source_f - beta_f u_f) D = 0
// with u_ref what the drag saw at the interval's begin, b'_p = (m_p/D) (1 - exp(-b_p D/m_p)).
#pragma once

#include <mpi.h>

#include <vector>

#include "cfd/fluid/fluid.h"
#include "coupling/forces/interval_end.h"
#include "coupling/particles/ledger.h"
#include "coupling/selection/census.h"
#include "coupling/two_grid/reader.h"

namespace twogrid {

class MomentumExchange {
 public:
  /// read_length: of what a particle reads (m). fluid and reader must live as long.
  MomentumExchange(MPI_Comm comm, const Fluid& fluid, Reader& reader, double read_length)
      : comm_(comm), fluid_(fluid), reader_(reader), read_length_(read_length) {}

  /// The reaction of all particles. places, drag: of selection.inside(). completed: the drag on the fluid's deviation
  /// from what particles read is completed (complete_drag()). Collective.
  void react(const Particles& p, const Selection& selection, const Places& places,
             const std::vector<ImplicitDrag>& drag, const Census& census, double interval, bool completed,
             Ledger& ledger);
  /// A given flow rate is that of fluid and particles together: exchange().particle_flux. flux_velocity[q] (m/s) belongs
  /// to who[q]. Collective.
  void set_particle_flux(const Particles& p, const std::vector<int>& who,
                         const std::vector<FourNumbers>& flux_velocity);
  /// The fluid has advanced: what it has received from the particles, for the ledger. Local.
  void count_reaction(double interval, Ledger& ledger);

  Interphase& exchange() { return exchange_; }
  const Interphase& exchange() const { return exchange_; }

 private:
  void complete_drag(const Particles& p, const std::vector<int>& who, const Places& places,
                     const std::vector<ImplicitDrag>& drag, double terms, double interval, Ledger& ledger);
  double deviation_response(const Particles& p, int i) const;

  MPI_Comm comm_;
  const Fluid& fluid_;
  Reader& reader_;
  double read_length_;
  Interphase exchange_;
  NodeSpread source_, beta_;                 // its rows
  NodeSpread deviation_, deviation_beta_;    // complete_drag(): then the source is held as a field
  std::array<std::vector<double>, 3> rows_;  // scratch: made rows of faces
  std::vector<FourNumbers> deviations_;      // scratch
};

}  // namespace twogrid
