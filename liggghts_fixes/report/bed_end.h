// What the drag of a bed that ends somewhere in a particle cell falls short by: c D/H of its pressure drop, D the particle
// cell along gravity, H the bed's height. c: means over places of the end, in the study bed_end (cases/studies).
#pragma once

#include <string>

#include "liggghts_fixes/report/scene_numbers.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

/// What may be missing without a warning.
constexpr double kMostMissing = 0.05;
/// What is lower, in grains, is no bed: a layer, or a few grains in a large vessel.
constexpr double kLeastGrains = 5;
/// A share of the pressure drop; 0: no bed to speak of.
inline double short_at_end(const SettledBed& bed, Deposit deposit) {
  return bed.along < 0 || bed.grains < kLeastGrains ? 0 : (deposit == Deposit::kTrilinear ? 0.40 : 0.27) / bed.cells;
}
/// The estimate is for beds of several particle cells.
inline std::string percent_short(double share) {
  return share > 0.3 ? "a third or more" : "about " + brief(100 * share) + " %";
}

}  // namespace twogrid
