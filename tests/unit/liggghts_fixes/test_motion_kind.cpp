// Which fixes move particles, by style.
// What would pass falsely without it: a style of another build of LIGGGHTS, which no run here can have, that counts as
// one that moves nothing, or the other way round, without a word; a style whose name begins like another's.
#include <gtest/gtest.h>

#include "liggghts_fixes/liggghts/motion_kind.h"

namespace twogrid {
namespace {

TEST(MotionKind, OfStyles) {
  const struct {
    const char* style;
    bool integrates, acts;
    MotionKind kind;
  } rows[] = {{"nve/sphere", true, true, MotionKind::kIntegrates},
              {"nve/limit", true, true, MotionKind::kIntegrates},
              {"nve/cfd_cn/sphere", false, true, MotionKind::kIntegrates},
              {"nvt/sphere", false, true, MotionKind::kIntegrates},
              {"brownian/own", true, true, MotionKind::kIntegrates},  // says so of itself
              {"nve/noforce", true, true, MotionKind::kKeeps},
              {"nve/sph/stationary", true, true, MotionKind::kNone},
              {"move", true, true, MotionKind::kPrescribes},
              {"move/mesh", false, true, MotionKind::kNone},
              {"heat/gran", false, true, MotionKind::kNone},
              {"heat/gran/radiation", false, true, MotionKind::kNone},
              {"mesh/surface/stress/6dof", false, true, MotionKind::kNone},
              {"transportequation/scalar", false, true, MotionKind::kNone},
              {"freeze", false, false, MotionKind::kFreezes},
              {"setforce", false, false, MotionKind::kSetsForce},
              {"lineforce", false, false, MotionKind::kSetsForce},
              {"planeforce", false, false, MotionKind::kSetsForce},
              {"aveforce", false, false, MotionKind::kShares},
              {"addforce", false, false, MotionKind::kNone},
              {"wall/gran", false, false, MotionKind::kNone},
              {"own/integrator", false, true, MotionKind::kUnknown},
              {"nvest", false, true, MotionKind::kUnknown},
              {"nvest", false, false, MotionKind::kNone}};
  for (const auto& row : rows) EXPECT_EQ(motion_kind(row.style, row.integrates, row.acts), row.kind) << row.style;
}

}  // namespace
}  // namespace twogrid
