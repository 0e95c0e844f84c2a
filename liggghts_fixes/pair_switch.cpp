#include "pair_switch.h"

#include <force.h>
#include <integrate.h>

namespace {

// The flag is protected; see style_registry.cpp for the way to it.
template <class Tag, typename Tag::type Member>
struct Reach {
  friend typename Tag::type member(Tag) { return Member; }
};
struct PairFlag {
  using type = int LAMMPS_NS::Integrate::*;
  friend type member(PairFlag);
};
template struct Reach<PairFlag, &LAMMPS_NS::Integrate::pair_compute_flag>;

}  // namespace

namespace twogrid {

void skip_pair(LAMMPS_NS::Integrate& integrate, bool skip, bool has_pair) {
  integrate.*member(PairFlag()) = has_pair && !skip ? 1 : 0;
}

}  // namespace twogrid
