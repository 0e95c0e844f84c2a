#include "liggghts_fixes/contacts/pair_switch.h"

#include <force.h>
#include <integrate.h>

#include "liggghts_fixes/private_member.h"

namespace {

struct PairFlag {
  using type = int LAMMPS_NS::Integrate::*;
  friend type member(PairFlag);
};
template struct PrivateMember<PairFlag, &LAMMPS_NS::Integrate::pair_compute_flag>;

}  // namespace

namespace twogrid {

void skip_pair(LAMMPS_NS::Integrate& integrate, bool skip, bool has_pair) {
  integrate.*member(PairFlag()) = has_pair && !skip ? 1 : 0;
}

}  // namespace twogrid
