// What LIGGGHTS' restart files lack of insertion: the random numbers of regions, and of fixes insert/..., particletemplate
// and particledistribution on all ranks but the first; the volume of a region as insert/pack and insert/rate/region have
// found it by random points. With it insertion goes on with the same particles at the same places.
#pragma once

#include <list>
#include <string>
#include <utility>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class RandomState {
 public:
  RandomState() = default;
  /// As it is now, of this rank.
  explicit RandomState(LAMMPS_NS::LAMMPS& lammps);
  /// LIGGGHTS takes these numbers over, when all its fixes are there. Collective.
  void restore(LAMMPS_NS::LAMMPS& lammps) const;

  /// f(name, entry): names from the IDs of regions and fixes. S: RandomState or const RandomState.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    for (auto& [name, value] : s.numbers_) f(name, value);
  }

 private:
  std::list<std::pair<std::string, double>> numbers_;
};

}  // namespace twogrid
