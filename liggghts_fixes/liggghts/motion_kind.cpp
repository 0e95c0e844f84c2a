#include "liggghts_fixes/liggghts/motion_kind.h"

namespace twogrid {

MotionKind motion_kind(const std::string& style, bool integrates, bool acts) {
  struct Row {
    const char* style;
    MotionKind kind;
  };
  static const Row rows[] = {{"move", MotionKind::kPrescribes},
                             {"nve/noforce", MotionKind::kKeeps},
                             {"nve/asphere/noforce", MotionKind::kKeeps},
                             {"nve/sph/stationary", MotionKind::kNone},
                             {"freeze", MotionKind::kFreezes},
                             {"setforce", MotionKind::kSetsForce},
                             {"lineforce", MotionKind::kSetsForce},
                             {"planeforce", MotionKind::kSetsForce},
                             {"enforce2d", MotionKind::kSetsForce},
                             {"aveforce", MotionKind::kShares}};
  // They act where integrators do, on temperatures, concentrations, meshes and marks.
  static const char* const others[] = {"heat/",     "transportequation/", "move/mesh",  "mesh/",
                                       "massflow/", "neighlist/",         "continuum/", "property/"};
  for (const Row& row : rows)
    if (style == row.style) return row.kind;
  if (integrates) return MotionKind::kIntegrates;
  for (const char* other : others)
    if (style.rfind(other, 0) == 0) return MotionKind::kNone;
  for (const char* family : {"nve", "nvt", "npt", "nph"})
    if (style == family || style.rfind(std::string(family) + "/", 0) == 0) return MotionKind::kIntegrates;
  return acts ? MotionKind::kUnknown : MotionKind::kNone;
}

}  // namespace twogrid
