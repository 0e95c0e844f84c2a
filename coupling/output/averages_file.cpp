#include <cmath>
#include <limits>

#include "coupling/output/averages.h"
#include "coupling/output/growing_file.h"
#include "coupling/two_grid/open_nodes.h"

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

double Averages::bytes() const {
  const double fine = double(fine_.cells().count()), coarse = double(coarse_.cells().count());
  const int fine_values = kFineSums, coarse_values = kGasSums + 10, batch_values = kGasBatchSums + kSolidsBatchSums;
  return 8 * (fine * fine_values + coarse * (coarse_values + kBatches * batch_values)) + 131072;
}

/// The sums, then those of the batches; nodes that share a value (open_nodes.h) have those of all of them.
std::vector<Array3<double>> Averages::all_solids() const {
  std::vector<Array3<double>> solids = window_at_owners();
  std::size_t c = 0;
  for_each(coarse_own_, [&](int, int, int) {
    for (int q = 0; q < kSolidsSums; ++q) solids[q].data()[c] += state_.solids.at(c)[q];
    for (int b = 0; b < kBatches; ++b)
      for (int q = 0; q < kSolidsBatchSums; ++q)
        solids[kSolidsSums + b * kSolidsBatchSums + q].data()[c] += state_.solids_batch[b].at(c)[q];
    ++c;
  });
  if (coarse_.open_nodes())
    for (Array3<double>& a : solids) coarse_.open_nodes()->total(slot_of(a));
  return solids;
}

void Averages::write(GrowingFile& file) const {
  const std::string at = "/average/", on_fine = at + "fine/", on_coarse = at + "particle_grid/",
                    in_batches = on_coarse + "batch/";
  for (const auto& g : {at, on_fine, on_coarse, in_batches}) file.group(g.substr(0, g.size() - 1));
  file.attribute("/average", "weight", state_.weight);
  file.attribute("/average", "samples", double(state_.samples));

  const std::vector<Array3<double>> solids = all_solids();
  std::vector<double> inverse_volume;
  for_each(coarse_own_, [&](int i, int j, int k) {
    const double volume = coarse_.shown_volume(i, j, k);
    inverse_volume.push_back(volume > 0 ? 1 / volume : 0);
  });

  std::vector<double> buffer;
  // value(cell, component) of own cells, in the order of the file.
  auto put = [&](const std::string& path, const Grid& grid, const Box& own, int components, const char* unit,
                 auto value) {
    buffer.resize(own.count() * components);
    for (std::size_t c = 0; c < own.count(); ++c)
      for (int d = 0; d < components; ++d) buffer[c * components + d] = value(c, d);
    file.slab(path, own_cells(grid.n(), own, components), buffer.data(), unit);
  };
  const double w = state_.weight;
  auto fine = [&](const char* name, int first, int components, const char* unit) {
    put(on_fine + name, fine_, fine_own_, components, unit,
        [&](std::size_t c, int d) { return state_.fine.at(c)[first + d] / w; });
  };
  auto fine_variance = [&](const char* name, int mean, int square, int components, const char* unit) {
    put(on_fine + name, fine_, fine_own_, components, unit, [&](std::size_t c, int d) {
      return variance(state_.fine.at(c)[square + d] / w, state_.fine.at(c)[mean + d] / w);
    });
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
        [&](std::size_t c, int d) { return state_.gas.at(c)[first + d] / w; });
  };
  auto gas_variance = [&](const char* name, int mean, int square, int components, const char* unit) {
    put(on_coarse + name, coarse_, coarse_own_, components, unit, [&](std::size_t c, int d) {
      return variance(state_.gas.at(c)[square + d] / w, state_.gas.at(c)[mean + d] / w);
    });
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
  file.replicated(in_batches + "weight", {state_.batch_weight.begin(), state_.batch_weight.end()}, {kBatches}, "s");
  std::array<double, kBatches> inverse_weight;
  for (int b = 0; b < kBatches; ++b) inverse_weight[b] = state_.batch_weight[b] > 0 ? 1 / state_.batch_weight[b] : 0;
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
    return [this, first](int b, std::size_t c, int d) { return state_.gas_batch[b].at(c)[first + d]; };
  };
  auto solids_in = [&](int first) {
    return [&solids, &inverse_volume, first](int b, std::size_t c, int d) {
      return solids[kSolidsSums + b * kSolidsBatchSums + first + d].data()[c] * inverse_volume[c];
    };
  };
  put_batches("eps", 1, "1", gas_in(kGasEps));
  put_batches("p", 1, "Pa", gas_in(kGasP));
  put_batches("gas_velocity", 3, "m/s", gas_in(kGasU));
  put_batches("gas_flux", 3, "m/s", gas_in(kGasFlux));
  put_batches("solids_fraction", 1, "1", solids_in(kSolidsVolume));
  put_batches("solids_flux", 3, "m/s", solids_in(kSolidsFlux));
}

}  // namespace twogrid
