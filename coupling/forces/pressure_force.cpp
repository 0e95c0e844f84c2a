#include "coupling/forces/pressure_force.h"

namespace twogrid {

void clear_pressure_force(Particles& p, const std::vector<int>& who) {
  for (int i : who)
    for (int d = 0; d < 3; ++d) p.state[i][kPressureForce + d] = 0;
}

void add_pressure_of_drag(Particles& p, const std::vector<int>& who, MeanMotion& motion, bool residual_read) {
  double beta;
  Vec3 drag;
  for (int i : who) {
    double* s = p.state[i];
    motion.drag_at(p.x[i], beta, drag);
    const double volume = sphere_volume(p.radius[i]);
    s[kResponse] = p.step[i][kDragCoefficient] + volume * beta;
    for (int d = 0; d < 3; ++d)
      s[kPressureForce + d] = (residual_read ? s[kPressureForce + d] : 0.0) + volume * drag[d];
  }
}

}  // namespace twogrid
