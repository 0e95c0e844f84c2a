#include "coupling/two_grid/reader.h"

#include <algorithm>

#include "coupling/two_grid/open_nodes.h"

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
    : comm_(comm),
      read_(read),
      width_(width),
      map_(comm, fluid, grid),
      cell_map_(fluid.grid(), map_.grid(), map_.own(), fluid.open_shares()) {
  move_region(region);
}

void Reader::move_region(const ParticleRegion& region) {
  window_ = Window(comm_, map_.grid(), map_.layout(), region, spread_of(read_), width_);
  shape_ = window_.shape();
  const Box both = intersect(window_.box(), map_.own());
  around_ = both.count() == map_.own().count();
  sum_.resize(window_.box().count());
  own_sum_.resize(around_ ? 0 : map_.own().count());
}

void Reader::find(const Particles& p, const std::vector<int>& who, Places& places) const {
  find_places(window_, p, who, places);
}

Slot<FourNumbers> Reader::own_field(int group, int groups) {
  if (around_) return {window_.box(), field_.data() + group, groups};
  return {map_.own(), own_field_.data() + group, groups};
}

namespace {

/// Component 3 of own nodes' groups, and what it says of the others: without faces components 0-2 are zero; flux: they
/// are divided by it.
void set_value(const ReadGroup& group, const Array3<double>* value, const Box& own, const Slot<FourNumbers>& to) {
  if (own.empty()) return;
  for (int k = own.lo[2]; k < own.hi[2]; ++k)
    for (int j = own.lo[1]; j < own.hi[1]; ++j) {
      FourNumbers* node = to.data + to.stride * to.index(own.lo[0], j, k);
      const double* const row = value ? value->data() + value->index(own.lo[0], j, k) : nullptr;
      for (int i = 0; i < own.size(0); ++i, node += to.stride) {
        if (!group.faces) node->at[0] = node->at[1] = node->at[2] = 0;
        if (group.eps) {
          const double inverse = 1 / row[i];
          for (int d = 0; d < 3; ++d) node->at[d] *= inverse;
        }
        node->at[3] = row ? row[i] : 0.0;
      }
    }
}

}  // namespace

void Reader::load(const std::vector<ReadGroup>& groups) {
  const int n = int(groups.size());
  const std::size_t values = window_.box().count() * n;
  if (field_.capacity() < values) std::vector<FourNumbers>().swap(field_);  // old and new are never there together
  field_.resize(values);
  own_field_.resize(around_ ? 0 : map_.own().count() * n);
  std::vector<Slot<FourNumbers>> own, window;
  const OpenNodes* const families = reads_fine_cells(read_) ? map_.grid().open_nodes() : nullptr;
  for (int g = 0; g < n; ++g) {
    own.push_back(own_field(g, n));
    window.push_back({window_.box(), field_.data() + g, n});
    if (groups[g].faces) map_.mean(*groups[g].faces, own[g], groups[g].eps);
    const Array3<double>* value = groups[g].value;
    if (families && value) {  // those of the particle grid's nodes show one value already, but not those of fine cells
      value_.reset(map_.own());
      for_each(map_.own(), [&](int i, int j, int k) { value_(i, j, k) = (*groups[g].value)(i, j, k); });
      families->average(value_);
      value = &value_;
    }
    set_value(groups[g], value, map_.own(), own[g]);
    cell_map_.mean(groups[g].cells, groups[g].cell_weight, own[g]);
  }
  window_.bring(own, window);
}

void Reader::react_at(const double x[3], const Four& whole) {
  if (window_.cut()) {
    SeenNodes seen;
    window_.see(x, seen);
    react(seen, whole);
  } else {
    Stencil w;
    window_.weights(x, w);
    react(w, whole);
  }
}

void Reader::clear_reaction() {
  std::fill(sum_.begin(), sum_.end(), FourWholeNumbers{});
}

/// The window's sums of all ranks, on own nodes.
Slot<FourWholeNumbers> Reader::own_sums() {
  const Slot<FourWholeNumbers> window{window_.box(), sum_.data(), 1};
  Slot<FourWholeNumbers> own = window;
  if (!around_) {
    std::fill(own_sum_.begin(), own_sum_.end(), FourWholeNumbers{});
    own = {map_.own(), own_sum_.data(), 1};
  }
  window_.add({window}, {own});
  return own;
}

void Reader::collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back) {
  held_back = map_.spread(own_sums(), scale, source, beta);
}

void Reader::collect(const std::array<FixedPoint, 2>& scale, const CellField<FineGrid>* weight,
                     const std::array<CellField<FineGrid>*, 4>& cells) {
  cell_map_.spread(own_sums(), scale, weight, cells);
}

}  // namespace twogrid
