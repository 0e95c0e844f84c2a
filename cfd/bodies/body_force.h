// The force of the fluid on a body in its grid (body_forces.h says what it is made of).
#pragma once

#include "cfd/grid/box.h"

namespace twogrid {

struct BodyForce {
  Vec3 friction{0, 0, 0}, pressure{0, 0, 0}, convection{0, 0, 0};  ///< on the body (N)
  Vec3 centre{0, 0, 0};                                            ///< of its surface in the fluid (m)
  Vec3 torque{0, 0, 0};                                            ///< about the centre (N m)
  /// Of what the body blows into the fluid (fluid/blowing.h), no part of its force: volume (m3/s), momentum (N).
  double blown = 0;
  Vec3 carried{0, 0, 0};
  Vec3 force() const {
    Vec3 sum;
    for (int d = 0; d < 3; ++d) sum[d] = friction[d] + pressure[d] + convection[d];
    return sum;
  }
  /// Torque about another point.
  Vec3 torque_about(const Vec3& point) const;
};

}  // namespace twogrid
