#include "liggghts_fixes/liggghts/unsupported.h"

#include <atom.h>
#include <domain.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>
#include <universe.h>
#include <update.h>

#include <cstring>

#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

void refuse_unsupported(LAMMPS& lammps, const std::string& id, const std::string& style) {
  Update* const update = lammps.update;
  Domain* const domain = lammps.domain;
  Modify* const modify = lammps.modify;
  Atom* const atom = lammps.atom;
  if (std::string(update->unit_style) != "si") refuse("units", update->unit_style, "units si");
  if (domain->dimension != 3)
    refuse("dimension", std::to_string(domain->dimension), "dimension 3 (one fine cell in the thin direction)");
  if (domain->triclinic) refuse("box", "a tilted one", "an orthogonal box");
  if (std::strcmp(update->integrate_style, "verlet") != 0)
    refuse("run_style", update->integrate_style, "verlet: the fluid is coupled to steps of one length");
  check_box_boundary(domain->boundary);
  if (!atom->radius_flag || !atom->rmass_flag)
    refuse("atom_style", "one without radius and mass", "atom_style granular (or sphere)");
  if (atom->superquadric_flag)
    refuse("atom_style", "superquadric", "atom_style granular (or sphere): drag on other shapes is not modelled");
  if (std::string(lammps.universe->version).find(" 3.8") == std::string::npos)
    refuse("LIGGGHTS", lammps.universe->version, "a twogrid that is linked with LIGGGHTS-PUBLIC 3.8");
  for (int f = 0; f < modify->nfix; ++f) {
    if (!modify->fix[f]) continue;  // the place of this very fix, when it replaces one of its id
    const std::string other = modify->fix[f]->style;
    if (modify->fix[f]->box_change_size || modify->fix[f]->box_change_shape)
      refuse("box", "fix " + std::string(modify->fix[f]->id) + " (" + other + "), which changes it during a run",
             "a box that stays as it is: the fluid's grid lies in it (unfix " + std::string(modify->fix[f]->id) + ")");
    if (other.rfind("multisphere", 0) == 0 || other == "concave" || other.rfind("rigid", 0) == 0)
      refuse("group", "bodies of several spheres (fix " + other + ")",
             "single spheres: drag on bodies is not modelled");
    for (const char* fluid : {"buoyancy", "couple/cfd", "lb/coupling"})
      if (other.rfind(fluid, 0) == 0)
        refuse("fix", "fix " + std::string(modify->fix[f]->id) + " " + other,
               "none beside fix twogrid: it has the fluid's forces, buoyancy in every fix gravity included, and they "
               "would "
               "count twice");
    if (other == style && std::string(modify->fix[f]->id) != id)
      refuse("fix", "a second fix twogrid beside " + std::string(modify->fix[f]->id), "one");
  }
}

std::vector<std::string> doubts(const LAMMPS& lammps) {
  std::vector<std::string> found;
  for (int f = 0; f < lammps.modify->nfix; ++f)
    if (std::string(lammps.modify->fix[f]->style) == "viscous")
      found.push_back("fix " + std::string(lammps.modify->fix[f]->id) +
                      " viscous is a drag of its own, on top of the fluid's; unfix it unless the particles are to be "
                      "held back");
  return found;
}

}  // namespace twogrid
