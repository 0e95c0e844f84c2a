// How long a script will take, from what was measured of its runs, on this and on other numbers of ranks. A model, for a
// plan. Pure functions.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

/// What the ranks' parts of the box hang on.
struct PlannedParts {
  Int3 bricks{1, 1, 1};                            ///< of the particles, as they were measured
  Int3 wanted{0, 0, 0};                            ///< by the script's `processors`; 0: LIGGGHTS chooses
  std::array<double, 3> length{1, 1, 1};           ///< of the box (m)
  std::array<double, 3> lo{0, 0, 0}, hi{1, 1, 1};  ///< where the particles will lie, in parts of the box
  bool follow = false;                             ///< borders follow the particles
};

/// One `run` of the script. Seconds are of the fullest rank, as measured on so many ranks.
struct PlannedRun {
  std::string line;      ///< as it was executed
  long long steps = 0;   ///< DEM steps
  bool at_most = false;  ///< it may end by itself
  double particles = 0;  ///< of all ranks, at its end
  double couplings = 0, fluid_steps = 0;
  double particle_seconds = 0;  ///< DEM, drag, and the coupling as far as it goes by particles
  double fluid_seconds = 0;
  double other_seconds = 0;       ///< set-up and output: what ranks don't share
  double reach = 0, spacing = 0;  ///< of particles: width of the ghosts' layer, mean distance (m); 0: unknown
  double cells = 0;               ///< of the fluid, all ranks
  PlannedParts parts;

  double seconds() const { return particle_seconds + fluid_seconds + other_seconds; }
};

/// Bricks for so many ranks: as the script wants them where that can be, else those of the least surface.
Int3 planned_bricks(const PlannedParts& parts, int ranks);
/// Whether the script's `processors` allows so many ranks.
bool script_allows(const PlannedParts& parts, int ranks);
/// Share of all particles in the fullest rank.
double fullest_share(const PlannedParts& parts, int ranks);
/// Seconds of a run on so many ranks.
double seconds_on(const PlannedRun& run, int ranks);
/// Bytes of the fullest rank on so many: what a process takes before anything is in it, and what it took at most on as many
/// ranks as the parts were measured on.
double bytes_on(const PlannedParts& parts, double empty, double most, int ranks);

/// Time of a message or a wait for another rank, within a machine (s): what two ranks lose per step, see tests/bench/README.md.
constexpr double kPlannedMessage = 6e-6;

}  // namespace twogrid
