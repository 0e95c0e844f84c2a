#include "liggghts_fixes/liggghts/restart_file.h"

#include <atom.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>

#include <cstring>
#include <stdexcept>

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// What Modify keeps of a restart file's fixes.
struct Restarted : Modify {
  static char** ids(Modify& m) { return m.*&Restarted::id_restart_global; }
  static char** particle_ids(Modify& m) { return m.*&Restarted::id_restart_peratom; }
  static int* places(Modify& m) { return m.*&Restarted::index_restart_peratom; }
  static char** states(Modify& m) { return m.*&Restarted::state_restart_global; }
};

}  // namespace

int values_in_restart(LAMMPS& lammps, const std::string& id) {
  Modify& modify = *lammps.modify;
  for (int i = 0; i < modify.nfix_restart_global; ++i)
    if (id == Restarted::ids(modify)[i]) {
      double values = 0;  // the first of its global state
      std::memcpy(&values, Restarted::states(modify)[i], sizeof values);
      return int(values);
    }
  return -1;
}

std::string id_in_restart(LAMMPS& lammps) {
  Modify& modify = *lammps.modify;
  const std::string end = "_state";
  for (int i = 0; i < modify.nfix_restart_global; ++i) {
    const std::string id = Restarted::ids(modify)[i];
    if (id.size() <= end.size() || id.substr(id.size() - end.size()) != end) continue;
    std::string owner = id.substr(0, id.size() - end.size());
    if (values_in_restart(lammps, owner + "_step") >= 0) return owner;
  }
  return "";
}

void check_columns_in_restart(LAMMPS& lammps, const std::string& name, int columns) {
  const int kept = values_in_restart(lammps, name);
  if (kept >= 0 && kept != columns)
    throw std::invalid_argument("the restart file holds " + std::to_string(kept) +
                                " values a particle for this fix, wanted " + std::to_string(columns) +
                                ": another version of twogrid has written it; give the fix another ID, and what it "
                                "knows of the particles begins anew");
}

void check_restarted(bool restarted, const std::string& checkpoint) {
  if (restarted || checkpoint.empty()) return;
  throw std::invalid_argument(
      "checkpoint read: found particles that this fix has no restart file's columns of, wanted "
      "those of the restart file written beside " +
      checkpoint + ": read_restart in place of the box, and the fix by the ID that it had");
}

void take_columns_again(LAMMPS& lammps, const char* only) {
  Modify& modify = *lammps.modify;
  for (int k = 0; k < modify.nfix_restart_peratom; ++k) {
    if (only && std::strcmp(Restarted::particle_ids(modify)[k], only) != 0) continue;
    const int f = modify.find_fix(Restarted::particle_ids(modify)[k]);
    if (f < 0 || std::strcmp(modify.fix[f]->style, "property/atom") != 0) continue;
    for (int i = 0; i < lammps.atom->nlocal; ++i) modify.fix[f]->unpack_restart(i, Restarted::places(modify)[k]);
  }
}

}  // namespace twogrid
