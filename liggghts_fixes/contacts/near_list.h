// Pairs of spheres that may touch soon: a short list out of LIGGGHTS' neighbours, kept until particles have moved so
// far that another pair could touch. Pairs in the order of LIGGGHTS' list, so that sums keep their order. Local to the
// rank.
#pragma once

#include <vector>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {

/// LIGGGHTS' half list with its history: rows of sphere ilist[0..rows).
struct NeighbourRows {
  int rows;
  const int *ilist, *count;
  int** neighbours;
  int** flags;
  double** history;
  int history_size;  ///< doubles a pair; the spring's three come first
};

class NearList {
 public:
  /// skin: reach of LIGGGHTS' list beyond contact, m.
  NearList(const ContactKernel& kernel, double skin) : kernel_(kernel), skin_(skin), gap_(0.25 * skin) {}

  /// The pairs in contact now. fresh: LIGGGHTS has made its list anew.
  void update(const Spheres& s, const NeighbourRows& rows, bool fresh);

  const double* packed() const { return packed_.data(); }
  const NearPair* pairs() const { return pairs_.data(); }
  const int* contacts() const { return contacts_.data(); }
  int contact_count() const { return contact_count_; }

 private:
  void make(const Spheres& s, const NeighbourRows& rows);
  void adapt_gap();

  const ContactKernel& kernel_;
  double skin_, gap_;
  std::vector<double> packed_, before_;  // x, y, z, r now, and when the list was made; two more that never touch
  std::vector<NearPair> pairs_;          // a multiple of four
  std::vector<int> contacts_, row_;
  int contact_count_ = 0, n_all_ = -1, steps_ = 0;
};

}  // namespace twogrid
