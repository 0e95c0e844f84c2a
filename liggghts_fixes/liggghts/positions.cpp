#include "liggghts_fixes/liggghts/positions.h"

#include <atom.h>
#include <lammps.h>
#include <update.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace twogrid {

void check_positions(LAMMPS_NS::LAMMPS& lammps) {
  const LAMMPS_NS::Atom& atom = *lammps.atom;
  double sum = 0;  // of zeros, and of what is not a number
  for (int i = 0; i < atom.nlocal; ++i) sum += 0 * (atom.x[i][0] + atom.x[i][1] + atom.x[i][2]);
  if (std::isfinite(sum)) return;
  long long lost = 0;
  int tag = 0;
  for (int i = 0; i < atom.nlocal; ++i)
    if (!std::isfinite(atom.x[i][0] + atom.x[i][1] + atom.x[i][2])) ++lost, tag = atom.tag[i];
  throw std::runtime_error(std::to_string(lost) + " particle(s) have a position that is not finite at step " +
                           std::to_string(lammps.update->ntimestep) + ", one of them tag " + std::to_string(tag) +
                           ": by a contact (a timestep too long for its stiffness and damping, or two spheres in one "
                           "place), or by a force that is not finite; reduce timestep, or take the overlap out");
}

}  // namespace twogrid
