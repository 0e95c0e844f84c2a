#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "cfd/parallel/reduction.h"
#include "coupling/output/averages.h"

namespace twogrid {

namespace {

/// Sums over cells of what the scatter of one quantity's batches says; by both weights, volume of solids and open volume.
struct Scatter {
  std::array<double, 2> batches{}, neighbours{}, samples{}, square{};

  void add(double value, const std::array<double, 2>& weight, std::array<double, 2>& sum) {
    for (int w = 0; w < 2; ++w) sum[w] += weight[w] * value;
  }
};

/// Of squares: variances that the difference of two sums of squares can't tell from 0.
constexpr double kCancelled = 1e-12;

}  // namespace

MeansError Averages::error(double at_rest) const {
  MeansError e;
  e.batches = state_.batch + (state_.batch_samples == state_.batch_length ? 1 : 0);
  if (!e.known()) return e;
  const int n = e.batches;
  double time = 0;
  for (int b = 0; b < n; ++b) time += state_.batch_weight[b];
  e.batch_time = time / n;

  std::array<double, 2> total{};
  double speed_squared = 0;
  Scatter of_eps, of_velocity, of_flux;
  std::size_t c = 0;
  for_each(coarse_own_, [&](int i, int j, int k) {
    const double volume = coarse_.shown_volume(i, j, k);
    const double* const sum = state_.gas.at(c);
    const double eps = sum[kGasEps] / state_.weight;
    const std::array<double, 2> weight{volume * std::max(0.0, 1 - eps), volume};
    if (volume > 0) {
      for (int w = 0; w < 2; ++w) total[w] += weight[w];
      const auto look = [&](Scatter& s, int q, int square) {
        double mean = 0, var = 0, lag = 0, before = 0;
        for (int b = 0; b < n; ++b) mean += state_.gas_batch[b].at(c)[q] / state_.batch_weight[b] / n;
        for (int b = 0; b < n; ++b) {
          const double off = state_.gas_batch[b].at(c)[q] / state_.batch_weight[b] - mean;
          var += off * off / (n - 1), lag += off * before / (n - 1);
          before = off;
        }
        s.add(var, weight, s.batches), s.add(lag, weight, s.neighbours), s.add(mean * mean, weight, s.square);
        const double whole = sum[q] / state_.weight;
        if (square >= 0) s.add(std::max(0.0, sum[square] / state_.weight - whole * whole), weight, s.samples);
      };
      look(of_eps, kGasEps, kGasEps2);
      for (int d = 0; d < 3; ++d) speed_squared += volume * sum[kGasU2 + d] / state_.weight;
      for (int d = 0; d < 3; ++d) look(of_velocity, kGasU + d, kGasU2 + d), look(of_flux, kGasFlux + d, -1);
    }
    ++c;
  });
  for (Scatter* s : {&of_eps, &of_velocity, &of_flux})
    for (int w = 0; w < 2; ++w)
      Reduction::over_ranks(comm_, {}, {&s->batches[w], &s->neighbours[w], &s->samples[w], &s->square[w]});
  Reduction::over_ranks(comm_, {}, {&total[0], &total[1], &speed_squared});

  const int w = total[0] > 1e-6 * total[1] ? 0 : 1;
  // The mean of n batches is theirs, so that neighbours seem less alike by 1/n than they are.
  const auto lag = [&](const Scatter& s) {
    return s.batches[w] > 0 ? std::max(0.0, s.neighbours[w] / s.batches[w] + 1.0 / n) : 0.0;
  };
  of_flux.square[w] = std::max(of_flux.square[w], at_rest * at_rest * total[w]);
  const auto scatter = [&](const Scatter& s) { return s.batches[w] > 0 ? std::sqrt(s.batches[w] / s.square[w]) : 0.0; };
  const auto relative = [&](const Scatter& s) { return scatter(s) * std::sqrt((1 + 2 * lag(s)) / n); };
  e.eps = relative(of_eps), e.flux = relative(of_flux);
  e.scatter = std::max(scatter(of_eps), scatter(of_flux));
  // That of round-off says nothing.
  for (const Scatter* s : {&of_eps, &of_flux})
    if (scatter(*s) > MeansError::kRoundOff) e.lag = std::max(e.lag, lag(*s));
  for (const Scatter* s : {&of_eps, &of_velocity})
    if (s->samples[w] > kCancelled * s->square[w])
      e.correlation_time =
          std::max(e.correlation_time, 0.5 * e.batch_time * s->batches[w] * (1 + 2 * lag(*s)) / s->samples[w]);
  double longest = 0;
  for (const Axis& a : fine_.axis) longest = std::max(longest, a.length());
  if (total[1] > 0) e.passes = state_.weight * std::sqrt(speed_squared / total[1]) / longest;
  return e;
}

}  // namespace twogrid
