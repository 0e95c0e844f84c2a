#include "liggghts_fixes/liggghts/random_state.h"

#include <domain.h>
#include <fix.h>
#include <fix_insert.h>
#include <fix_insert_pack.h>
#include <fix_particledistribution_discrete.h>
#include <fix_template_sphere.h>
#include <lammps.h>
#include <modify.h>
#include <random_park.h>
#include <region.h>

#include <algorithm>

#include "liggghts_fixes/private_member.h"

namespace {

using namespace LAMMPS_NS;

#define PRIVATE(Name, Owner, Type, what) \
  struct Name {                          \
    using type = Type Owner::*;          \
    friend type member(Name);            \
  };                                     \
  template struct PrivateMember<Name, &Owner::what>
PRIVATE(RegionRandom, Region, RanPark*, random);
PRIVATE(InsertRandom, FixInsert, RanPark*, random);
PRIVATE(PackVolume, FixInsertPack, double, region_volume);
PRIVATE(PackOwnVolume, FixInsertPack, double, region_volume_local);
PRIVATE(DistributionRandom, FixParticledistributionDiscrete, RanPark*, random);
PRIVATE(TemplateRandom, FixTemplateSphere, RanPark*, random_insertion);
PRIVATE(TemplatePoints, FixTemplateSphere, RanPark*, random_mc);
PRIVATE(Kept, RanPark, int, save);
PRIVATE(Second, RanPark, double, second);
#undef PRIVATE

/// Calls f(name, generator) and g(name, number) for all that there are.
template <class F, class G>
void for_each(LAMMPS& lammps, F&& f, G&& g) {
  Domain& domain = *lammps.domain;
  for (int r = 0; r < domain.nregion; ++r)
    f("region_" + std::string(domain.regions[r]->id), domain.regions[r]->*member(RegionRandom()));
  Modify& modify = *lammps.modify;
  for (int i = 0; i < modify.nfix; ++i) {
    const std::string name = "fix_" + std::string(modify.fix[i]->id);
    if (auto* insert = dynamic_cast<FixInsert*>(modify.fix[i])) f(name, insert->*member(InsertRandom()));
    if (auto* pack = dynamic_cast<FixInsertPack*>(modify.fix[i])) {
      g(name + "_volume", pack->*member(PackVolume()));
      g(name + "_own_volume", pack->*member(PackOwnVolume()));
    }
    if (auto* distribution = dynamic_cast<FixParticledistributionDiscrete*>(modify.fix[i]))
      f(name, distribution->*member(DistributionRandom()));
    if (auto* grain = dynamic_cast<FixTemplateSphere*>(modify.fix[i])) {
      f(name, grain->*member(TemplateRandom()));
      f(name + "_points", grain->*member(TemplatePoints()));
    }
  }
}

/// As a name in a file's group.
std::string plain(std::string id) {
  std::replace(id.begin(), id.end(), '/', '_');
  return id;
}

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

RandomState::RandomState(LAMMPS& lammps) {
  for_each(
      lammps,
      [&](const std::string& name, RanPark* random) {
        if (!random) return;
        numbers_.emplace_back(plain(name) + "_random", random->state());
        const bool kept = random->*member(Kept()) == 1;  // of a pair of normal numbers the second
        numbers_.emplace_back(plain(name) + "_kept", kept);
        numbers_.emplace_back(plain(name) + "_second", kept ? random->*member(Second()) : 0.0);
      },
      [&](const std::string& name, double number) { numbers_.emplace_back(plain(name), number); });
}

void RandomState::restore(LAMMPS& lammps) const {
  // Else they would find volumes and rates, by random points, in the next run's set-up.
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i])) insert->init(), insert->setup(0);
  const auto find = [&](const std::string& name, double otherwise) {
    for (const auto& [known, value] : numbers_)
      if (known == plain(name)) return value;
    return otherwise;
  };
  for_each(
      lammps,
      [&](const std::string& name, RanPark* random) {
        const double state = find(name + "_random", 0);
        if (!random || !(state > 0)) return;
        random->reset(int(state));
        random->*member(Kept()) = find(name + "_kept", 0) == 1;
        random->*member(Second()) = find(name + "_second", 0);
      },
      [&](const std::string& name, double& number) { number = find(name, number); });
}

}  // namespace twogrid
