#include "coupling/control/between_runs.h"

namespace twogrid {

void note_columns(Particles& p) {
  for (int i = 0; i < p.n; ++i) {
    double* s = p.state[i];
    if (!p.takes_part(i) || s[kKnown] == 0) continue;
    for (int d = 0; d < 3; ++d) s[kPosition + d] -= p.x[i][d];
    s[kRestMass] = p.mass[i], s[kRestRadius] = p.radius[i];
  }
}

double take_up_columns(Particles& p, const StepForces& forces) {
  double grown = 0;
  for (int i = 0; i < p.n; ++i) {
    double* s = p.state[i];
    if (!p.takes_part(i) || s[kKnown] == 0) continue;
    for (int d = 0; d < 3; ++d) s[kPosition + d] += p.x[i][d];
    if (p.mass[i] != s[kRestMass]) forces.renew_decay(p, i);
    if (p.radius[i] != s[kRestRadius] && s[kVoidFraction] != 0)
      grown += sphere_volume(p.radius[i]) - sphere_volume(s[kRestRadius]);
    s[kRestRadius] = p.radius[i];
  }
  return grown;
}

}  // namespace twogrid
