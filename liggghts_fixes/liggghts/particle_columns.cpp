#include "liggghts_fixes/liggghts/particle_columns.h"

#include <atom.h>
#include <domain.h>
#include <fix_property_atom.h>
#include <lammps.h>
#include <modify.h>

#include <cstdio>
#include <cstring>
#include <vector>

#include "liggghts_fixes/liggghts/motion.h"

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

long long particles_of_all_ranks(LAMMPS& lammps) {
  long long n = lammps.atom->nlocal;
  MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPI_LONG_LONG, MPI_SUM, lammps.world);
  return n;
}

double* particle_property(LAMMPS& lammps, const std::string& name) {
  Fix* fix = lammps.modify->find_fix_property(name.c_str(), "property/atom", "scalar", 0, 0, "twogrid", false);
  return fix ? static_cast<FixPropertyAtom*>(fix)->vector_atom : nullptr;
}

Particles view_particles(LAMMPS& lammps, int group, const Motion& motion, FixPropertyAtom& state,
                         FixPropertyAtom& step) {
  using Three = double(*)[3];
  const Atom& atom = *lammps.atom;
  const Domain& domain = *lammps.domain;
  Particles p;
  p.n = atom.nlocal;
  p.x = reinterpret_cast<Three>(atom.x ? atom.x[0] : nullptr);
  p.v = reinterpret_cast<Three>(atom.v ? atom.v[0] : nullptr);
  p.f = reinterpret_cast<Three>(atom.f ? atom.f[0] : nullptr);
  p.radius = atom.radius;
  p.mass = atom.rmass;
  p.tag = atom.tag;
  p.mask = atom.mask;
  p.group = group;
  for (int d = 0; d < 3; ++d)
    p.moving[d] = motion.moving[d], p.fixed[d] = motion.fixed[d], p.frozen[d] = motion.frozen[d];
  p.still = motion.still;
  p.growing = motion.grows;
  p.state = state.array_atom;
  p.step = step.array_atom;
  for (int d = 0; d < 3; ++d)
    if (domain.periodicity[d]) p.period[d] = domain.prd[d];
  return p;
}

long long inserted_particles(LAMMPS& lammps) {
  long long inserted = 0;
  for (int i = 0; i < lammps.modify->nfix; ++i) {
    Fix& fix = *lammps.modify->fix[i];
    if (std::strncmp(fix.style, "insert/", 7) == 0) inserted += (long long)fix.compute_vector(0);
  }
  return inserted;
}

}  // namespace twogrid
