// What LIGGGHTS' restart files lack of fixes insert/...: that an insertion is done, which LIGGGHTS takes for one to begin;
// and of those that go on, the random numbers that they draw from (their own and their distribution's on all ranks but the first,
// their region's or face's; particletemplate/sphere draws none: its sizes are constants), and volumes and shares that they have found by
// random points. With it insertion goes on with the same particles at the same places. The rest, such as the number
// inserted and the next step, the restart file holds.
#pragma once

#include <mpi.h>

#include <list>
#include <string>
#include <utility>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class InsertionState {
 public:
  InsertionState() = default;
  /// As it is now, of this rank. to_read: with the names of all that a file may hold for these fixes.
  explicit InsertionState(LAMMPS_NS::LAMMPS& lammps, bool to_read = false);
  /// From text(), for this rank: of another number of ranks nothing that a rank has of its own.
  InsertionState(const std::string& text, int rank, int ranks);
  /// Of all ranks, on rank 0. Collective.
  std::string text(MPI_Comm comm) const;
  /// Drops what a rank has of its own: its part of the box was another.
  void forget_ranks();
  /// LIGGGHTS takes it over, when all its fixes are there. Collective.
  void restore(LAMMPS_NS::LAMMPS& lammps) const;

  /// f(name, entry): names from the IDs of regions and fixes. S: InsertionState or const InsertionState.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    for (auto& [name, value] : s.numbers_) f(name, value);
  }

 private:
  std::list<std::pair<std::string, double>> numbers_;
};

}  // namespace twogrid
