// What LIGGGHTS' restart files lack of insertion: the random numbers of regions, and of fixes insert/... and
// particledistribution on all ranks but the first (particletemplate/sphere draws none: its sizes are constants); the
// volume of a region as insert/pack and insert/rate/region have found it by random points; steps and numbers of an
// insertion that is done, which LIGGGHTS takes for one to begin. With it insertion goes on with the same particles at the
// same places.
#pragma once

#include <mpi.h>

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
  /// From text(), for this rank. Of another number of ranks: steps and numbers only.
  RandomState(const std::string& text, int rank, int ranks);
  /// Of all ranks, on rank 0. Collective.
  std::string text(MPI_Comm comm) const;
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
