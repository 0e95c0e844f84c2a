#include "read.h"

#include <algorithm>

namespace twogrid {

bool reads_fine_cells(Read read) {
  return read != Read::kCell && read != Read::kTrilinear;
}

Spread spread_of(Read read) {
  switch (read) {
    case Read::kTrilinear:
    case Read::kFineTrilinear:
      return Spread::kLinear;
    case Read::kKernel:
      return Spread::kKernel;
    case Read::kCube:
      return Spread::kCube;
    default:
      return Spread::kCell;
  }
}

Reader::Reader(MPI_Comm comm, const Fluid& fluid, const ParticleGrid& grid, const ParticleRegion& region, Read read,
               double width)
    : comm_(comm), read_(read), width_(width), map_(comm, fluid, grid) {
  for (auto& a : node_sum_) a.reset(map_.own());
  for (auto& a : node_reaction_) a.reset(map_.own());
  move_region(region);
}

void Reader::move_region(const ParticleRegion& region) {
  window_ = Window(comm_, map_.grid(), map_.layout(), region, spread_of(read_), width_);
  shape_ = window_.shape();
  sum_.resize(window_.box().count());
}

void Reader::find(const Particles& p, const std::vector<int>& who, Places& places) const {
  find_places(window_, p, who, places);
}

void Reader::load(const Readable& fields, int groups) {
  const FaceField<FineGrid>* const faces[kMaxGroups] = {fields.velocity, fields.mean, fields.pressure};
  field_.resize(window_.box().count() * groups);
  double* const first = field_.data()->at;
  std::vector<const Array3<double>*> owner;
  std::vector<Slot<double>> window;
  auto add = [&](const Array3<double>& field, int value) {
    owner.push_back(&field);
    window.push_back({window_.box(), first + value, 4 * groups});
  };
  for (int g = 0; g < groups; ++g) {
    if (!faces[g]) continue;
    if (node_field_[g][0].size() == 0)
      for (auto& a : node_field_[g]) a.reset(map_.own());
    map_.mean(*faces[g], node_field_[g]);
    for (int d = 0; d < 3; ++d) add(node_field_[g][d], 4 * g + d);
  }
  if (fields.eps) add(*fields.eps, 3);
  if (int(owner.size()) < 3 * groups) std::fill(field_.begin(), field_.end(), FourNumbers{});
  window_.bring<double>(owner, window);
}

void Reader::clear_reaction() {
  std::fill(sum_.begin(), sum_.end(), FourWholeNumbers{});
}

void Reader::collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back) {
  std::vector<Slot<long long>> window;
  for (int c = 0; c < kReactions; ++c) {
    node_sum_[c].fill(0);
    window.push_back({window_.box(), sum_.data()->at + c, 4});
  }
  window_.add(window, {&node_sum_[0], &node_sum_[1], &node_sum_[2], &node_sum_[3]});
  for (int c = 0; c < kReactions; ++c) {
    const FixedPoint& unit = scale[c < 3 ? 0 : 1];
    for (std::size_t m = 0; m < node_sum_[c].size(); ++m)
      node_reaction_[c].data()[m] = unit.value(node_sum_[c].data()[m]);
  }
  held_back = map_.spread({&node_reaction_[0], &node_reaction_[1], &node_reaction_[2]}, source);
  map_.spread({&node_reaction_[3], &node_reaction_[3], &node_reaction_[3]}, beta);
}

}  // namespace twogrid
