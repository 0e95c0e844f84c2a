#include "liggghts_fixes/contacts/near_list.h"

#include <algorithm>

namespace twogrid {
namespace {

// Steps that a list should last: making it costs about as much as some ten steps of testing its pairs.
constexpr int kFewSteps = 8, kManySteps = 40;
constexpr double kGapStep = 1.5, kSmallestGap = 0.05;  // the latter of the skin

}  // namespace

void NearList::update(const Spheres& s, const NeighbourRows& rows, bool fresh) {
  const std::size_t doubles = 4 * (std::size_t(s.n_all) + 2);
  if (s.n_all != n_all_) {
    n_all_ = s.n_all;
    packed_.assign(doubles, 0.0);
    before_.assign(doubles, 0.0);
    packed_[doubles - 4] = before_[doubles - 4] = 1.0;  // the second of the two: a metre from the first, no radius
    fresh = true;
  }
  const Drift drift = kernel_.pack(s, packed_.data(), before_.data());
  ++steps_;
  if (fresh || drift.radius_changed || 2 * drift.distance > gap_) {
    if (!fresh) adapt_gap();
    make(s, rows);
  }
  contact_count_ = kernel_.touching(packed_.data(), pairs_.data(), int(pairs_.size()), contacts_.data());
}

/// The faster particles move, the wider the list.
void NearList::adapt_gap() {
  if (steps_ < kFewSteps) gap_ = std::min(kGapStep * gap_, skin_);
  if (steps_ > kManySteps) gap_ = std::max(gap_ / kGapStep, kSmallestGap * skin_);
}

void NearList::make(const Spheres& s, const NeighbourRows& rows) {
  std::copy(packed_.begin(), packed_.end(), before_.begin());
  pairs_.clear();
  for (int row = 0; row < rows.rows; ++row) {
    const int i = rows.ilist[row], n = rows.count[i];
    const int* j = rows.neighbours[i];
    if (row_.size() < std::size_t(n) + 1) row_.resize(2 * n + 1);
    const int found = kernel_.near_pairs(packed_.data(), i, j, n, gap_, row_.data());
    for (int k = 0; k < found; ++k) {
      const int at = row_[k];
      pairs_.push_back({i, j[at], rows.history[i] + long(rows.history_size) * at, rows.flags[i] + at});
    }
  }
  while (pairs_.size() % 4) pairs_.push_back({s.n_all, s.n_all + 1, nullptr, nullptr});
  contacts_.resize(pairs_.size() + 1);
  steps_ = 0;
}

}  // namespace twogrid
