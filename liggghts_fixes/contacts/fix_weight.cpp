#include "liggghts_fixes/contacts/fix_weight.h"

#include <atom.h>

#include "liggghts_fixes/contacts/contact_laws.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {
constexpr int kConstant = 0;  // of LIGGGHTS' varflag: magnitude and direction are no variables
}

bool FixWeight::served() const {
  return varflag == kConstant && !fm && !fix_relax && atom->rmass && atom->nlocal > 0;
}

void FixWeight::post_force(int vflag) {
  if (!served()) {
    FixGravity::post_force(vflag);
    return;
  }
  const double g[3] = {xacc, yacc, zacc};
  kernel_.add_weight(spheres(*lmp), groupbit, g);
  eflag = 0;
}

double FixWeight::compute_scalar() {
  if (served() && eflag == 0) {
    egrav = 0;
    for (int i = 0; i < atom->nlocal; ++i)
      if (atom->mask[i] & groupbit) {
        const double* x = atom->x[i];
        egrav -= atom->rmass[i] * (xacc * x[0] + yacc * x[1] + zacc * x[2]);
      }
  }
  return FixGravity::compute_scalar();
}

}  // namespace twogrid
