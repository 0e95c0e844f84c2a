// What LIGGGHTS' fixes do to positions and velocities, by their style.
#pragma once

#include <string>

namespace twogrid {

enum class MotionKind {
  kNone,        ///< positions and velocities are not its affair
  kIntegrates,  ///< velocities follow from forces
  kKeeps,       ///< particles go on with the velocity they have (nve/noforce)
  kPrescribes,  ///< positions and velocities are given, perhaps in some directions only (move)
  kSetsForce,   ///< forces are overwritten, perhaps in some directions only (setforce, lineforce, planeforce)
  kFreezes,     ///< forces are zero
  kShares,      ///< forces become those of others (aveforce)
  kUnknown      ///< it acts where integrators act, and its style is not known here
};

/// integrates: the fix says of itself that it does; acts: it is called where integrators are.
MotionKind motion_kind(const std::string& style, bool integrates, bool acts);

}  // namespace twogrid
