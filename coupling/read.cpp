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
  for (auto& a : window_sum_) a.reset(window_.box());
  window_field_.clear();
}

namespace {

TWOGRID_VECTORISED void find_nodes(const Window& window, const Particles& p, const std::vector<int>& who,
                                   std::ptrdiff_t* node) {
  for (std::size_t q = 0; q < who.size(); ++q) node[q] = window.node(p.x[who[q]]);
}

TWOGRID_VECTORISED void find_corners(const Window& window, const Particles& p, const std::vector<int>& who,
                                     Corners* corners) {
  const std::size_t n = who.size();
  if (!window.uniform()) {
    for (std::size_t q = 0; q < n; ++q) corners[q] = window.corners(p.x[who[q]]);
    return;
  }
  const Window::UniformPairs pairs = window.uniform_pairs();
  for (std::size_t q = 0; q < n; ++q) {
    Four x;
    three_at(p.x[who[q]], who[q] + 1 == p.n, x);
    Window::corners(pairs, x, corners[q]);
  }
}

/// One value of the group of every node.
void interleave(const Array3<double>& from, int stride, double* to) {
  const double* const value = from.data();
  for (std::size_t m = 0, n = from.size(); m < n; ++m) to[m * stride] = value[m];
}

}  // namespace

void Reader::find(const Particles& p, const std::vector<int>& who, Places& places) const {
  if (window_.spread() == Spread::kCell) {
    places.node.resize(who.size());
    find_nodes(window_, p, who, places.node.data());
  } else if (window_.spread() == Spread::kLinear) {
    places.corners.resize(who.size());
    find_corners(window_, p, who, places.corners.data());
  }
}

void Reader::load(const Readable& fields, int groups) {
  const FaceField<FineGrid>* const faces[kMaxGroups] = {fields.velocity, fields.mean, fields.pressure};
  while (int(window_field_.size()) < 4 * groups) window_field_.emplace_back(window_.box());
  std::vector<const Array3<double>*> owner;
  std::vector<Array3<double>*> window;
  std::vector<int> value;  // place of the field in the groups
  for (int g = 0; g < groups; ++g) {
    if (!faces[g]) continue;
    if (node_field_[g][0].size() == 0)
      for (auto& a : node_field_[g]) a.reset(map_.own());
    map_.mean(*faces[g], node_field_[g]);
    for (int d = 0; d < 3; ++d) owner.push_back(&node_field_[g][d]), value.push_back(4 * g + d);
  }
  if (fields.eps) owner.push_back(fields.eps), value.push_back(3);
  for (int v : value) window.push_back(&window_field_[v]);
  window_.bring<double>(owner, window);
  field_.resize(window_.box().count() * groups);
  if (int(value.size()) < 3 * groups) std::fill(field_.begin(), field_.end(), FourNumbers{});
  for (std::size_t a = 0; a < value.size(); ++a)
    interleave(*window[a], 4 * groups, reinterpret_cast<double*>(field_.data()) + value[a]);
}

void Reader::clear_reaction() {
  std::fill(sum_.begin(), sum_.end(), FourWholeNumbers{});
}

void Reader::collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back) {
  for (int c = 0; c < kReactions; ++c) {
    node_sum_[c].fill(0);
    for (std::size_t m = 0; m < sum_.size(); ++m) window_sum_[c].data()[m] = sum_[m].at[c];
  }
  window_.add({&window_sum_[0], &window_sum_[1], &window_sum_[2], &window_sum_[3]},
              {&node_sum_[0], &node_sum_[1], &node_sum_[2], &node_sum_[3]});
  for (int c = 0; c < kReactions; ++c) {
    const FixedPoint& unit = scale[c < 3 ? 0 : 1];
    for (std::size_t m = 0; m < node_sum_[c].size(); ++m)
      node_reaction_[c].data()[m] = unit.value(node_sum_[c].data()[m]);
  }
  held_back = map_.spread({&node_reaction_[0], &node_reaction_[1], &node_reaction_[2]}, source);
  map_.spread({&node_reaction_[3], &node_reaction_[3], &node_reaction_[3]}, beta);
}

}  // namespace twogrid
