#include "liggghts_fixes/contacts/fix_sphere_motion.h"

#include <atom.h>
#include <domain.h>

#include "liggghts_fixes/liggghts/positions.h"

namespace twogrid {

using namespace LAMMPS_NS;

bool FixSphereMotion::served() const {
  return extra == 0 && !useAM_ && domain->dimension == 3 && igroup != atom->firstgroup && atom->nlocal > 0;
}

void FixSphereMotion::half_step(double dt) {
  kernel_.kick({dtf, dt, onePlusCAddRhoFluid_, atom->nlocal, groupbit, atom->x[0], atom->v[0], atom->omega[0],
                atom->f[0], atom->torque[0], atom->radius, atom->rmass, atom->mask});
}

int FixSphereMotion::setmask() {
  return FixNVESphere::setmask() | FixConst::PRE_EXCHANGE;
}

/// Comes with every new neighbour list.
void FixSphereMotion::pre_exchange() {
  check_positions(*lmp);
}

void FixSphereMotion::initial_integrate(int vflag) {
  if (served())
    half_step(dtv);
  else
    FixNVESphere::initial_integrate(vflag);
}

void FixSphereMotion::final_integrate() {
  if (served())
    half_step(0);
  else
    FixNVESphere::final_integrate();
}

}  // namespace twogrid
