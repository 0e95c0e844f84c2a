#include "read.h"

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
    : map_(comm, fluid, grid), window_(comm, grid, map_.layout(), region, spread_of(read), width) {
  for (auto& a : velocity_) a.reset(map_.own());
  for (auto& a : window_field_) a.reset(window_.box());
  for (auto& a : window_sum_) a.reset(window_.box());
  for (auto& a : node_sum_) a.reset(map_.own());
  for (auto& a : node_reaction_) a.reset(map_.own());
}

void Reader::load(const FaceField<FineGrid>& velocity) {
  map_.mean(velocity, velocity_);
  window_.bring<double>({&velocity_[0], &velocity_[1], &velocity_[2]},
                        {&window_field_[0], &window_field_[1], &window_field_[2]});
}

void Reader::load(const FaceField<FineGrid>& velocity, const Array3<double>& eps) {
  map_.mean(velocity, velocity_);
  window_.bring<double>({&velocity_[0], &velocity_[1], &velocity_[2], &eps},
                        {&window_field_[0], &window_field_[1], &window_field_[2], &window_field_[3]});
}

void Reader::load(const FaceField<FineGrid>& velocity, const Array3<double>& eps, const FaceField<FineGrid>& residual) {
  if (residual_[0].size() != velocity_[0].size())
    for (auto& a : residual_) a.reset(map_.own());
  map_.mean(velocity, velocity_);
  map_.mean(residual, residual_);
  window_.bring<double>(
      {&velocity_[0], &velocity_[1], &velocity_[2], &eps, &residual_[0], &residual_[1], &residual_[2]},
      {&window_field_[0], &window_field_[1], &window_field_[2], &window_field_[3], &window_field_[4], &window_field_[5],
       &window_field_[6]});
}

void Reader::clear_reaction() {
  for (auto& a : window_sum_) a.fill(0);
}

void Reader::collect(const std::array<FixedPoint, 2>& scale, NodeSpread& source, NodeSpread& beta, Vec3& held_back) {
  for (auto& a : node_sum_) a.fill(0);
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
