#include "liggghts_fixes/liggghts/particle_columns.h"

#include <fix_property_atom.h>
#include <lammps.h>
#include <modify.h>

#include <cstdio>
#include <vector>

namespace twogrid {

using namespace LAMMPS_NS;

FixPropertyAtom* keep_with_particles(LAMMPS& lammps, const std::string& name, int columns) {
  std::vector<std::string> words{name, "all", "property/atom", name, "vector", "yes", "no", "no"};
  words.insert(words.end(), columns, "0.");
  std::vector<char*> pointers;
  for (std::string& w : words) pointers.push_back(w.data());
  // LIGGGHTS warns of vectors longer than 20 by a text that is of no use to anyone here.
  FILE *const shown = lammps.screen, *const logged = lammps.logfile;
  lammps.screen = lammps.logfile = nullptr;
  FixPropertyAtom* const made = lammps.modify->add_fix_property_atom(int(pointers.size()), pointers.data(), "twogrid");
  lammps.screen = shown, lammps.logfile = logged;
  return made;
}

double* particle_property(LAMMPS& lammps, const std::string& name) {
  Fix* fix = lammps.modify->find_fix_property(name.c_str(), "property/atom", "scalar", 0, 0, "twogrid", false);
  return fix ? static_cast<FixPropertyAtom*>(fix)->vector_atom : nullptr;
}

}  // namespace twogrid
