// What a bed will do in a run that is only planned, as far as its contacts cost time. Estimates, for a plan. Pure functions.
#pragma once

#include "cfd/grid/grid.h"
#include "coupling/settings.h"
#include "liggghts_fixes/report/scene_numbers.h"

namespace twogrid {

/// Contacts a particle, each counted once: of a settled bed; where the fluid carries it, bubbling or expanded. Measured in
/// beds of 1200 to 9600 spheres (liggghts_fixes/run/README.md).
constexpr double kSettledContacts = 2.4, kCarriedContacts = 0.2;

/// Share of the bed whose particles the fluid carries, 0 to 1: by what comes in beneath it against minimum fluidisation. A jet
/// through a bed at rest moves three times its own section. Negative: nothing blows, or there is no bed.
double carried_share(const Settings& settings, const FineGrid& grid, const SceneNumbers& numbers,
                     const SettledBed& bed);

/// What a plan must know of a bed: see carried_share; the gas through it on the whole (superficial, m/s).
struct PlannedBed {
  double share = -1, U_bed = 0;
};

/// How often a DEM step builds the neighbour lists: once the fastest particle has moved by half the skin (m). It goes at some
/// 0.65 of the gas's superficial velocity: 0.5 to 0.9 in six beds of 9240 to 92,900 spheres that bubble or have a jet, 1.3 in
/// a spouted one.
double planned_builds(const PlannedBed& bed, double skin, double dt);

/// The mean of a run's contacts. share: carried (negative: nothing blows); measured: contacts as they are now; falls: seconds
/// that particles will still fall for, of `seconds`.
double planned_contacts(double share, double measured, double falls, double seconds);

}  // namespace twogrid
