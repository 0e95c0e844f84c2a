// The void fraction's levels in time, in cells and on faces.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/grid/void_fraction.h"

namespace twogrid {

/// With open shares: keeps eps in `whole` (null: nowhere) and makes it theta eps, as the levels have it.
void take_open_part(const FluidDomain& domain, CellField<FineGrid>& eps, CellField<FineGrid>* whole);
/// eps on the faces from that of the cells, halo filled. Collective.
void set_face_eps(const FluidDomain& domain, FluidState& state);
/// eps at fraction s of the interval becomes the newest level. Collective.
void next_level(const FluidDomain& domain, const VoidFractionInTime& eps, double s, double interval, FluidState& state);
/// Takes next_level() back, for it to be called anew.
void previous_level(FluidState& state);
/// Particles came or went: eps changes at once to `now`, in the past levels too, so that no velocity follows from it.
/// same_flux: eps u is kept, and not u. Collective.
void replace_fluid(const FluidDomain& domain, const CellField<FineGrid>& now, bool same_flux, FluidState& state);

}  // namespace twogrid
