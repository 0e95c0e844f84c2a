#include "fix_sphere_motion.h"

#include <atom.h>
#include <domain.h>

namespace twogrid {

using namespace LAMMPS_NS;

namespace {
constexpr double kInertia = 0.4;  // of a sphere, over m r^2
}

bool FixSphereMotion::served() const {
  return extra == 0 && !useAM_ && domain->dimension == 3 && igroup != atom->firstgroup;
}

/// Half a kick, and with kDrift the move of a whole step between kick of velocity and of spin.
template <bool kDrift>
void FixSphereMotion::kick() {
  double *const x = atom->x[0], *const v = atom->v[0], *const omega = atom->omega[0];
  const double *const f = atom->f[0], *const torque = atom->torque[0];
  const double *const radius = atom->radius, *const mass = atom->rmass;
  const int* const mask = atom->mask;
  const double dt_spin = dtf / kInertia;
  // Divisions are dear, and mostly the next sphere is like the last.
  double m = 0, r = 0, per_mass = 0, per_inertia = 0;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!(mask[i] & groupbit)) continue;
    if (mass[i] != m || radius[i] != r) {
      m = mass[i];
      r = radius[i];
      per_mass = dtf / m;
      per_inertia = dt_spin / (r * r * m);
    }
    for (int k = 3 * i; k < 3 * i + 3; ++k) {
      v[k] += per_mass * f[k];
      if (kDrift) x[k] += dtv * v[k];
      omega[k] += per_inertia * torque[k];
    }
  }
}

void FixSphereMotion::initial_integrate(int vflag) {
  if (served())
    kick<true>();
  else
    FixNVESphere::initial_integrate(vflag);
}

void FixSphereMotion::final_integrate() {
  if (served())
    kick<false>();
  else
    FixNVESphere::final_integrate();
}

}  // namespace twogrid
