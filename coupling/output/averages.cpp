#include "coupling/output/averages.h"

#include <algorithm>
#include <cmath>

#include "cfd/grid/pi.h"
#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/fixed_point.h"

namespace twogrid {

Averages::Averages(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& coarse)
    : comm_(comm),
      fine_(fine),
      coarse_(coarse),
      coarse_layout_(node_layout(layout, coarse)),
      fine_own_(layout.cells(rank_of(comm))),
      coarse_own_(coarse_layout_.cells(rank_of(comm))) {
  begin_anew();
  for (int i = fine_own_.lo[0]; i < fine_own_.hi[0]; ++i) width_.push_back(fine.axis[0].width(i));
  open_width_.resize(coarse.ratio[0]);
  // A particle may lie a little outside the rank's cells; one particle cell around them saves the first growth.
  if (!coarse_own_.empty()) grow_window(coarse_own_.lo);
}

void Averages::begin_anew() {
  state_ = AveragesState{};
  state_.fine.reset(fine_own_, kFineSums);
  state_.gas.reset(coarse_own_, kGasSums), state_.solids.reset(coarse_own_, kSolidsSums);
  for (auto& b : state_.gas_batch) b.reset(coarse_own_, kGasBatchSums);
  for (auto& b : state_.solids_batch) b.reset(coarse_own_, kSolidsBatchSums);
  for (auto& a : beyond_sum_) a.fill(0);
  for (auto& b : beyond_batch_)
    for (auto& a : b) a.fill(0);
}

void Averages::add(double weight, const Fluid& fluid, const Particles& particles) {
  next_batch();
  add_gas(weight, fluid);
  add_solids(weight, particles);
  state_.weight += weight;
  state_.batch_weight[state_.batch] += weight;
  ++state_.samples;
  ++state_.batch_samples;
}

void Averages::next_batch() {
  AveragesState& s = state_;
  if (s.batch_samples < s.batch_length) return;
  s.batch_samples = 0;
  if (++s.batch < kBatches) return;
  // All are full: 2b and 2b + 1 become b.
  for (int b = 0; b < kBatches; ++b) {
    const int to = b / 2;
    const bool adds = b % 2 == 1;
    auto merge = [&](double* target, double* source, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        const double value = source[i];
        source[i] = 0;
        target[i] = adds ? target[i] + value : value;
      }
    };
    merge(&s.batch_weight[to], &s.batch_weight[b], 1);
    merge(s.gas_batch[to].data(), s.gas_batch[b].data(), s.gas_batch[b].size());
    merge(s.solids_batch[to].data(), s.solids_batch[b].data(), s.solids_batch[b].size());
    for (int q = 0; q < kSolidsBatchSums; ++q)
      merge(beyond_batch_[to][q].data(), beyond_batch_[b][q].data(), beyond_batch_[b][q].size());
  }
  s.batch = kBatches / 2;
  s.batch_length *= 2;
}

void Averages::add_gas(double weight, const Fluid& fluid) {
  const auto& u = fluid.velocity();
  const auto& eps = fluid.void_fraction();
  const auto& p = fluid.pressure();
  const Box& own = fine_own_;
  const std::ptrdiff_t row = own.size(0), slab = row * own.size(1);
  const OpenShares* const open = fluid.open_shares();
  std::size_t c = 0;
  for_each(coarse_own_, [&](int I, int J, int K) {
    double block[kGasFlux + 3] = {0, 0, 0, 0, 0, 0, 0, 0}, volume = 0;
    const Box cells = coarse_.block(I, J, K);
    const int i0 = cells.lo[0], across = cells.size(0);
    for (int k = cells.lo[2]; k < cells.hi[2]; ++k)
      for (int j = cells.lo[1]; j < cells.hi[1]; ++j) {
        const double area = fine_.axis[1].width(j) * fine_.axis[2].width(k);
        const double* width = width_.data() + (i0 - own.lo[0]);
        if (open) {
          const double* const theta = open->theta().data() + open->theta().index(i0, j, k);
          for (int i = 0; i < across; ++i) open_width_[i] = width[i] * theta[i];
          width = open_width_.data();
        }
        double* s = state_.fine.at((i0 - own.lo[0]) + row * (j - own.lo[1]) + slab * (k - own.lo[2]));
        const double* eps_row = eps.data() + eps.index(i0, j, k);
        const double* p_row = p.data() + p.index(i0, j, k);
        const double *low[3], *high[3];
        for (int d = 0; d < 3; ++d) low[d] = u[d].data() + u[d].index(i0, j, k), high[d] = low[d] + u[d].stride(d);
        for (int i = 0; i < across; ++i, s += kFineSums) {
          const double v = area * width[i], e = eps_row[i], q = p_row[i];
          const double centre[3] = {0.5 * (low[0][i] + high[0][i]), 0.5 * (low[1][i] + high[1][i]),
                                    0.5 * (low[2][i] + high[2][i])};
          s[kFineEps] += weight * e;
          s[kFineP] += weight * q;
          s[kFineEps2] += weight * e * e;
          s[kFineP2] += weight * q * q;
          volume += v;
          block[kGasEps] += v * e;
          block[kGasP] += v * q;
          for (int d = 0; d < 3; ++d) {
            s[kFineU + d] += weight * centre[d];
            s[kFineFlux + d] += weight * e * centre[d];
            s[kFineU2 + d] += weight * centre[d] * centre[d];
            block[kGasU + d] += v * centre[d];
            block[kGasFlux + d] += v * e * centre[d];
          }
        }
      }
    if (volume > 0)  // else inside a body
      for (double& b : block) b /= volume;
    double *s = state_.gas.at(c), *batch = state_.gas_batch[state_.batch].at(c);
    for (int q = 0; q < kGasBatchSums; ++q) {
      s[q] += weight * block[q];
      batch[q] += weight * block[q];
    }
    for (int q = 0; q < kGasFlux; ++q) s[kGasEps2 + q] += weight * block[q] * block[q];
    ++c;
  });
}

void Averages::add_solids(double weight, const Particles& particles) {
  double largest = 0, fastest = 0;
  for (int i = 0; i < particles.n; ++i) {
    if (!particles.takes_part(i)) continue;
    const double r = particles.radius[i];
    largest = std::max(largest, r * r * r);
    for (int d = 0; d < 3; ++d) fastest = std::max(fastest, std::abs(particles.v[i][d]));
  }
  const double volume = weight * 4.0 / 3.0 * kPi;
  largest *= volume;
  const double terms = particles.n;
  const FixedPoint of_volume(largest, terms), of_flux(largest * fastest, terms),
      of_square(largest * fastest * fastest, terms);
  std::fill(sample_.begin(), sample_.end(), std::array<long long, kSolidsSums>{});
  for (int i = 0; i < particles.n; ++i) {
    if (!particles.takes_part(i)) continue;
    Int3 cell;
    bool inside = true;
    for (int d = 0; d < 3; ++d) {
      const Axis& axis = coarse_.axis[d];
      double x = particles.x[i][d];
      int image = 0;
      if (axis.periodic()) {
        // Not wrapped back by the owner yet: its cell in the next image is near, the one in the first image is not.
        image = int(std::floor((x - axis.lo()) / axis.length()));
        x -= image * axis.length();
        cell[d] = std::min(std::max(axis.find(x), 0), axis.n() - 1) + image * axis.n();
      } else {
        cell[d] = axis.find(x);
        inside = inside && cell[d] >= 0 && cell[d] < axis.n();
      }
    }
    if (!inside) continue;
    if (!window_.contains(cell[0], cell[1], cell[2])) grow_window(cell);
    const double r = particles.radius[i], wv = volume * (r * r * r);
    const double* v = particles.v[i];
    auto& sum = sample_[CellTable<ParticleGrid>::place(window_, cell[0], cell[1], cell[2])];
    sum[kSolidsVolume] += of_volume.quantise(wv);
    for (int d = 0; d < 3; ++d) {
      sum[kSolidsFlux + d] += of_flux.quantise(wv * v[d]);
      sum[kSolidsV2 + d] += of_square.quantise(wv * v[d] * v[d]);
    }
  }
  std::size_t c = 0;
  for_each(window_, [&](int i, int j, int k) {
    const auto& whole = sample_[c++];
    if (whole[kSolidsVolume] == 0) return;
    double sum[kSolidsSums];
    for (int q = 0; q < kSolidsSums; ++q)
      sum[q] = (q == kSolidsVolume ? of_volume : q < kSolidsV2 ? of_flux : of_square).value(whole[q]);
    if (coarse_own_.contains(i, j, k)) {
      const auto own = CellTable<ParticleGrid>::place(coarse_own_, i, j, k);
      double *all = state_.solids.at(own), *batch = state_.solids_batch[state_.batch].at(own);
      for (int q = 0; q < kSolidsSums; ++q) all[q] += sum[q];
      for (int q = 0; q < kSolidsBatchSums; ++q) batch[q] += sum[q];
    } else {
      for (int q = 0; q < kSolidsSums; ++q) beyond_sum_[q](i, j, k) += sum[q];
      for (int q = 0; q < kSolidsBatchSums; ++q) beyond_batch_[state_.batch][q](i, j, k) += sum[q];
    }
  });
}

void Averages::grow_window(const Int3& cell) {
  const Box old = window_;
  Box grown{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
  grown = grown.grown(1);
  const auto cover = [&](const Box& b) {
    for (int d = 0; d < 3 && !b.empty(); ++d)
      grown.lo[d] = std::min(grown.lo[d], b.lo[d]), grown.hi[d] = std::max(grown.hi[d], b.hi[d]);
  };
  cover(old);
  if (!coarse_own_.empty()) cover(coarse_own_.grown(1));
  auto move = [&](Array3<double>& a) {
    Array3<double> b(grown);
    for_each(old, [&](int i, int j, int k) { b(i, j, k) = a(i, j, k); });
    a.swap(b);
  };
  for (auto& a : beyond_sum_) move(a);
  for (auto& b : beyond_batch_)
    for (auto& a : b) move(a);
  std::vector<std::array<long long, kSolidsSums>> sample(grown.count(), std::array<long long, kSolidsSums>{});
  std::size_t c = 0;
  for_each(old, [&](int i, int j, int k) { sample[CellTable<ParticleGrid>::place(grown, i, j, k)] = sample_[c++]; });
  sample_.swap(sample);
  window_ = grown;
}

std::vector<Array3<double>> Averages::window_at_owners() const {
  const int ranks = ranks_of(comm_);
  std::vector<Box> windows(ranks);
  static_assert(sizeof(Box) == 6 * sizeof(int), "boxes are sent as six integers");
  MPI_Allgather(&window_, 6, MPI_INT, windows.data(), 6, MPI_INT, comm_);
  const BlockExchange exchange(comm_, coarse_layout_.all_cells(), windows, coarse_.n(), coarse_.periodic());
  std::vector<const Array3<double>*> from;
  for (const auto& a : beyond_sum_) from.push_back(&a);
  for (const auto& b : beyond_batch_)
    for (const auto& a : b) from.push_back(&a);
  std::vector<Array3<double>> solids(from.size(), Array3<double>(coarse_own_));
  std::vector<Array3<double>*> to;
  for (auto& a : solids) to.push_back(&a);
  exchange.add(from, to);
  return solids;
}

void Averages::gather() {
  const std::vector<Array3<double>> solids = window_at_owners();
  std::size_t c = 0;
  for_each(coarse_own_, [&](int i, int j, int k) {
    for (int q = 0; q < kSolidsSums; ++q) state_.solids.at(c)[q] += solids[q](i, j, k);
    for (int b = 0; b < kBatches; ++b)
      for (int q = 0; q < kSolidsBatchSums; ++q)
        state_.solids_batch[b].at(c)[q] += solids[kSolidsSums + b * kSolidsBatchSums + q](i, j, k);
    ++c;
  });
  for (auto& a : beyond_sum_) a.fill(0);
  for (auto& b : beyond_batch_)
    for (auto& a : b) a.fill(0);
}

}  // namespace twogrid
