// LIGGGHTS' Neighbor with a faster way to find the pairs of spheres: the same pairs in the same order, with the same
// history, in LIGGGHTS' own lists.
#pragma once

#include <neighbor.h>

#include <vector>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {

class Neighbours : public LAMMPS_NS::Neighbor {
 public:
  /// Takes over the settings, and all that stock owns.
  Neighbours(const LAMMPS_NS::Neighbor& stock, const ContactKernel& kernel) : Neighbor(stock), kernel_(kernel) {}

 protected:
  /// LIGGGHTS chooses; where that is granular_bin_no_newton, find_pairs() takes its place.
  void choose_build(int index, LAMMPS_NS::NeighRequest* request) override;

 private:
  void find_pairs(LAMMPS_NS::NeighList* list);
  void sort_by_bins();
  void find_runs(const LAMMPS_NS::NeighList& list);

  const ContactKernel& kernel_;
  std::vector<double> x_, y_, z_, r_;  // own particles and ghosts in the order of bins; three more, never near
  std::vector<int> index_;             // their indices
  std::vector<int> start_, bin_;       // first place of each bin, and the end; bin of each particle
  std::vector<BinRun> runs_;           // of the stencil
  std::vector<int> found_;
};

/// From here on LIGGGHTS finds pairs by it. Call before the box is made; what the script has said of lists stays.
void replace_neighbour_lists(LAMMPS_NS::LAMMPS& lammps, const ContactKernel& kernel);

}  // namespace twogrid
