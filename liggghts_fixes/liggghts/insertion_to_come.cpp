#include "liggghts_fixes/liggghts/insertion_to_come.h"

#include <fix.h>
#include <fix_insert.h>
#include <fix_insert_pack.h>
#include <lammps.h>
#include <modify.h>
#include <update.h>

#include <algorithm>

#include "liggghts_fixes/private_member.h"

namespace {

using namespace LAMMPS_NS;

PRIVATE_MEMBER(ToHasEnd, FixInsert, int, ninsert_exists);
PRIVATE_MEMBER(ToWanted, FixInsert, int, ninsert);
PRIVATE_MEMBER(ToInserted, FixInsert, int, ninserted);
PRIVATE_MEMBER(AtOnce, FixInsert, double, ninsert_per);
PRIVATE_MEMBER(InRegion, FixInsertPack, int, ntotal_region);

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

ComingParticles pass_insertions(LAMMPS& lammps, long long end) {
  ComingParticles coming;
  for (int i = 0; i < lammps.modify->nfix; ++i) {
    auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i]);
    if (!insert || insert->next_reneighbor <= 0 || insert->next_reneighbor > end) continue;
    const long long every = insert->ins_every(), next = insert->next_reneighbor;
    const long long times = every > 0 ? (end - next) / every + 1 : 1;
    double at_once = insert->*member(AtOnce());
    if (auto* pack = dynamic_cast<FixInsertPack*>(insert)) {
      at_once = std::max(at_once, double(pack->*member(InRegion())));
      coming.at_most = coming.at_most || times > 1;
    }
    double number = double(times) * at_once;
    bool done = every == 0;
    if (insert->*member(ToHasEnd())) {
      const double left = insert->*member(ToWanted()) - insert->*member(ToInserted());
      done = done || number >= left;
      number = std::max(0.0, std::min(number, left));
      insert->*member(ToInserted()) += int(number);
    }
    coming.number += number;
    insert->next_reneighbor = done ? 0 : next + times * every;
  }
  return coming;
}

std::vector<std::string> last_insertions(LAMMPS& lammps, long long end) {
  std::vector<std::string> ids;
  for (int i = 0; i < lammps.modify->nfix; ++i) {
    auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i]);
    if (insert && insert->next_reneighbor > 0 && insert->next_reneighbor <= end && insert->ins_every() == 0)
      ids.push_back(insert->id);
  }
  return ids;
}

double without_room(LAMMPS& lammps, const std::vector<std::string>& ids) {
  double missing = 0;
  for (const std::string& id : ids) {
    const int at = lammps.modify->find_fix(id.c_str());
    auto* insert = at < 0 ? nullptr : dynamic_cast<FixInsert*>(lammps.modify->fix[at]);
    if (!insert) continue;
    double wanted = insert->*member(ToHasEnd()) ? insert->*member(ToWanted()) : 0;
    if (auto* pack = dynamic_cast<FixInsertPack*>(insert)) wanted = std::max(wanted, double(pack->*member(InRegion())));
    missing += std::max(0.0, wanted - insert->*member(ToInserted()));
  }
  return missing;
}

}  // namespace twogrid
