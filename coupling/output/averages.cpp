#include "coupling/output/averages.h"

#include <cmath>
#include <limits>

#include "cfd/grid/pi.h"
#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/hdf5_file.h"

namespace twogrid {

namespace {

/// Where own cells of a grid go in a dataset [nz][ny][nx], or [nz][ny][nx][components].
Slab own_cells(const Int3& n, const Box& own, std::size_t components) {
  Slab s;
  for (int d = 2; d >= 0; --d) {
    s.extent.push_back(n[d]);
    s.offset.push_back(own.empty() ? 0 : own.lo[d]);
    s.count.push_back(own.empty() ? 0 : own.size(d));
  }
  if (components > 1) s.extent.push_back(components), s.offset.push_back(0), s.count.push_back(components);
  return s;
}

/// The same with a leading dimension of batches.
Slab batched(Slab s, std::size_t batches) {
  s.extent.insert(s.extent.begin(), batches);
  s.offset.insert(s.offset.begin(), 0);
  s.count.insert(s.count.begin(), batches);
  return s;
}

double variance(double mean_of_square, double mean) {
  return std::max(0.0, mean_of_square - mean * mean);
}

}  // namespace

Averages::Averages(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& coarse)
    : comm_(comm),
      fine_(fine),
      coarse_(coarse),
      coarse_layout_(node_layout(layout, coarse)),
      fine_own_(layout.cells(rank_of(comm))),
      coarse_own_(coarse_layout_.cells(rank_of(comm))) {
  fine_sum_.assign(fine_own_.count(), {});
  gas_sum_.assign(coarse_own_.count(), {});
  for (auto& b : gas_batch_) b.assign(coarse_own_.count(), {});
  // A particle may lie a little outside the rank's cells; one particle cell around them saves the first growth.
  const Box window = coarse_own_.empty() ? Box{} : coarse_own_.grown(1);
  for (auto& a : solids_sum_) a.reset(window);
  for (auto& b : solids_batch_)
    for (auto& a : b) a.reset(window);
}

void Averages::add(double weight, const Fluid& fluid, const Particles& particles) {
  next_batch();
  add_gas(weight, fluid);
  add_solids(weight, particles);
  weight_ += weight;
  batch_weight_[batch_] += weight;
  ++samples_;
  ++batch_samples_;
}

void Averages::next_batch() {
  if (batch_samples_ < batch_length_) return;
  batch_samples_ = 0;
  if (++batch_ < kBatches) return;
  // All are full: 2b and 2b + 1 become b.
  for (int b = 0; b < kBatches; ++b) {
    const int to = b / 2;
    const bool adds = b % 2 == 1;
    auto merge = [&](double& target, double& source) {
      const double value = source;
      source = 0;
      target = adds ? target + value : value;
    };
    merge(batch_weight_[to], batch_weight_[b]);
    for (std::size_t c = 0; c < gas_sum_.size(); ++c)
      for (int q = 0; q < kGasBatchSums; ++q) merge(gas_batch_[to][c][q], gas_batch_[b][c][q]);
    for (int q = 0; q < kSolidsBatchSums; ++q)
      for (std::size_t c = 0; c < solids_batch_[b][q].size(); ++c)
        merge(solids_batch_[to][q].data()[c], solids_batch_[b][q].data()[c]);
  }
  batch_ = kBatches / 2;
  batch_length_ *= 2;
}

void Averages::add_gas(double weight, const Fluid& fluid) {
  const auto& u = fluid.velocity();
  const auto& eps = fluid.void_fraction();
  const auto& p = fluid.pressure();
  const Box& own = fine_own_;
  const std::ptrdiff_t row = own.size(0), slab = row * own.size(1);
  std::size_t c = 0;
  for_each(coarse_own_, [&](int I, int J, int K) {
    double block[kGasFlux + 3] = {0, 0, 0, 0, 0, 0, 0, 0}, volume = 0;
    const Box cells = coarse_.block(I, J, K);
    const int i0 = cells.lo[0], across = cells.size(0);
    for (int k = cells.lo[2]; k < cells.hi[2]; ++k)
      for (int j = cells.lo[1]; j < cells.hi[1]; ++j) {
        const double area = fine_.axis[1].width(j) * fine_.axis[2].width(k);
        auto* sum = &fine_sum_[(i0 - own.lo[0]) + row * (j - own.lo[1]) + slab * (k - own.lo[2])];
        const double* eps_row = eps.data() + eps.index(i0, j, k);
        const double* p_row = p.data() + p.index(i0, j, k);
        const double *low[3], *high[3];
        for (int d = 0; d < 3; ++d) low[d] = u[d].data() + u[d].index(i0, j, k), high[d] = low[d] + u[d].stride(d);
        for (int i = 0; i < across; ++i, ++sum) {
          const double v = area * fine_.axis[0].width(i0 + i), e = eps_row[i], q = p_row[i];
          const double centre[3] = {0.5 * (low[0][i] + high[0][i]), 0.5 * (low[1][i] + high[1][i]),
                                    0.5 * (low[2][i] + high[2][i])};
          auto& s = *sum;
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
    for (double& b : block) b /= volume;
    auto& s = gas_sum_[c];
    for (int q = 0; q < kGasEps2; ++q) s[q] += weight * block[q];
    for (int q = 0; q < kGasBatchSums; ++q) {
      s[kGasEps2 + q] += weight * block[q] * block[q];
      gas_batch_[batch_][c][q] += weight * block[q];
    }
    ++c;
  });
}

void Averages::add_solids(double weight, const Particles& particles) {
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
    if (!solids_sum_[0].box().contains(cell[0], cell[1], cell[2])) grow_window(cell);
    const double r = particles.radius[i], wv = weight * 4.0 / 3.0 * kPi * r * r * r;
    const double* v = particles.v[i];
    const auto at = solids_sum_[0].index(cell[0], cell[1], cell[2]);
    auto& batch = solids_batch_[batch_];
    solids_sum_[kSolidsVolume].data()[at] += wv;
    batch[kSolidsVolume].data()[at] += wv;
    for (int d = 0; d < 3; ++d) {
      solids_sum_[kSolidsFlux + d].data()[at] += wv * v[d];
      solids_sum_[kSolidsV2 + d].data()[at] += wv * v[d] * v[d];
      batch[kSolidsFlux + d].data()[at] += wv * v[d];
    }
  }
}

void Averages::grow_window(const Int3& cell) {
  const Box old = solids_sum_[0].box();
  Box grown{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
  grown = grown.grown(1);
  if (!old.empty())
    for (int d = 0; d < 3; ++d)
      grown.lo[d] = std::min(grown.lo[d], old.lo[d]), grown.hi[d] = std::max(grown.hi[d], old.hi[d]);
  auto move = [&](Array3<double>& a) {
    Array3<double> b(grown);
    for_each(old, [&](int i, int j, int k) { b(i, j, k) = a(i, j, k); });
    a.swap(b);
  };
  for (auto& a : solids_sum_) move(a);
  for (auto& b : solids_batch_)
    for (auto& a : b) move(a);
}

double Averages::bytes() const {
  const double fine = double(fine_.cells().count()), coarse = double(coarse_.cells().count());
  const int fine_values = kFineSums, coarse_values = kGasSums + 10, batch_values = kGasBatchSums + kSolidsBatchSums;
  return 8 * (fine * fine_values + coarse * (coarse_values + kBatches * batch_values)) + 131072;
}

void Averages::write(Hdf5File& file) const {
  const std::string at = "/average/", on_fine = at + "fine/", on_coarse = at + "particle_grid/",
                    in_batches = on_coarse + "batch/";
  for (const auto& g : {at, on_fine, on_coarse, in_batches}) file.group(g.substr(0, g.size() - 1));
  file.attribute("/average", "weight", weight_);
  file.attribute("/average", "samples", double(samples_));

  // Solids: windows -> owners.
  const int ranks = ranks_of(comm_);
  std::vector<Box> windows(ranks);
  const Box window = solids_sum_[0].box();
  static_assert(sizeof(Box) == 6 * sizeof(int), "boxes are sent as six integers");
  MPI_Allgather(&window, 6, MPI_INT, windows.data(), 6, MPI_INT, comm_);
  const BlockExchange exchange(comm_, coarse_layout_.all_cells(), windows, coarse_.n(), coarse_.periodic());
  std::vector<const Array3<double>*> from;
  for (const auto& a : solids_sum_) from.push_back(&a);
  for (const auto& b : solids_batch_)
    for (const auto& a : b) from.push_back(&a);
  std::vector<Array3<double>> solids(from.size(), Array3<double>(coarse_own_));
  std::vector<Array3<double>*> to;
  for (auto& a : solids) to.push_back(&a);
  exchange.add(from, to);
  std::vector<double> inverse_volume;
  for_each(coarse_own_, [&](int i, int j, int k) { inverse_volume.push_back(1 / coarse_.volume(i, j, k)); });

  std::vector<double> buffer;
  // value(cell, component) of own cells, in the order of the file.
  auto put = [&](const std::string& path, const Grid& grid, const Box& own, int components, const char* unit,
                 auto value) {
    buffer.resize(own.count() * components);
    for (std::size_t c = 0; c < own.count(); ++c)
      for (int d = 0; d < components; ++d) buffer[c * components + d] = value(c, d);
    file.slab(path, own_cells(grid.n(), own, components), buffer.data(), unit);
  };
  const double w = weight_;
  auto fine = [&](const char* name, int first, int components, const char* unit) {
    put(on_fine + name, fine_, fine_own_, components, unit,
        [&](std::size_t c, int d) { return fine_sum_[c][first + d] / w; });
  };
  auto fine_variance = [&](const char* name, int mean, int square, int components, const char* unit) {
    put(on_fine + name, fine_, fine_own_, components, unit,
        [&](std::size_t c, int d) { return variance(fine_sum_[c][square + d] / w, fine_sum_[c][mean + d] / w); });
  };
  fine("eps", kFineEps, 1, "1");
  fine("p", kFineP, 1, "Pa");
  fine("u", kFineU, 3, "m/s");
  fine("flux", kFineFlux, 3, "m/s");
  fine_variance("eps_variance", kFineEps, kFineEps2, 1, "1");
  fine_variance("p_variance", kFineP, kFineP2, 1, "Pa2");
  fine_variance("u_variance", kFineU, kFineU2, 3, "m2/s2");

  auto gas = [&](const char* name, int first, int components, const char* unit) {
    put(on_coarse + name, coarse_, coarse_own_, components, unit,
        [&](std::size_t c, int d) { return gas_sum_[c][first + d] / w; });
  };
  auto gas_variance = [&](const char* name, int mean, int square, int components, const char* unit) {
    put(on_coarse + name, coarse_, coarse_own_, components, unit,
        [&](std::size_t c, int d) { return variance(gas_sum_[c][square + d] / w, gas_sum_[c][mean + d] / w); });
  };
  gas("eps", kGasEps, 1, "1");
  gas("p", kGasP, 1, "Pa");
  gas("gas_velocity", kGasU, 3, "m/s");
  gas("gas_flux", kGasFlux, 3, "m/s");
  gas_variance("eps_variance", kGasEps, kGasEps2, 1, "1");
  gas_variance("p_variance", kGasP, kGasP2, 1, "Pa2");
  gas_variance("gas_velocity_variance", kGasU, kGasU2, 3, "m2/s2");

  // Where no particle ever was there is no velocity.
  const double none = std::numeric_limits<double>::quiet_NaN();
  auto sum = [&](int q, std::size_t c) { return solids[q].data()[c]; };
  auto per_solids = [&](int q, std::size_t c) {
    return sum(kSolidsVolume, c) > 0 ? sum(q, c) / sum(kSolidsVolume, c) : none;
  };
  put(on_coarse + "solids_fraction", coarse_, coarse_own_, 1, "1",
      [&](std::size_t c, int) { return sum(kSolidsVolume, c) * inverse_volume[c] / w; });
  put(on_coarse + "solids_flux", coarse_, coarse_own_, 3, "m/s",
      [&](std::size_t c, int d) { return sum(kSolidsFlux + d, c) * inverse_volume[c] / w; });
  put(on_coarse + "solids_velocity", coarse_, coarse_own_, 3, "m/s",
      [&](std::size_t c, int d) { return per_solids(kSolidsFlux + d, c); });
  put(on_coarse + "solids_velocity_variance", coarse_, coarse_own_, 3, "m2/s2", [&](std::size_t c, int d) {
    const double square = per_solids(kSolidsV2 + d, c);
    return std::isnan(square) ? none : variance(square, per_solids(kSolidsFlux + d, c));
  });

  // Batches: those without a sample have weight zero and values zero.
  file.replicated(in_batches + "weight", {batch_weight_.begin(), batch_weight_.end()}, {kBatches}, "s");
  std::array<double, kBatches> inverse_weight;
  for (int b = 0; b < kBatches; ++b) inverse_weight[b] = batch_weight_[b] > 0 ? 1 / batch_weight_[b] : 0;
  const std::size_t cells = coarse_own_.count();
  auto put_batches = [&](const std::string& name, int components, const char* unit, auto value) {
    buffer.resize(kBatches * cells * components);
    for (int b = 0; b < kBatches; ++b)
      for (std::size_t c = 0; c < cells; ++c)
        for (int d = 0; d < components; ++d)
          buffer[(b * cells + c) * components + d] = value(b, c, d) * inverse_weight[b];
    file.slab(in_batches + name, batched(own_cells(coarse_.n(), coarse_own_, components), kBatches), buffer.data(),
              unit);
  };
  auto gas_in = [&](int first) {
    return [this, first](int b, std::size_t c, int d) { return gas_batch_[b][c][first + d]; };
  };
  auto solids_in = [&](int first) {
    return [&solids, &inverse_volume, first](int b, std::size_t c, int d) {
      return solids[kSolidsSums + b * kSolidsBatchSums + first + d].data()[c] * inverse_volume[c];
    };
  };
  put_batches("eps", 1, "1", gas_in(kGasEps));
  put_batches("p", 1, "Pa", gas_in(kGasP));
  put_batches("gas_velocity", 3, "m/s", gas_in(kGasU));
  put_batches("solids_fraction", 1, "1", solids_in(kSolidsVolume));
  put_batches("solids_flux", 3, "m/s", solids_in(kSolidsFlux));
}

}  // namespace twogrid
