#include "coupling/output/start_up.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace twogrid {

namespace {

constexpr int kLeastBins = 32, kGroups = 8;
constexpr double kRoundOff = 1e-9;  // of a number itself
const char* const kNames[kFlowNumbers] = {"pressure drop", "solids' height", "solids' kinetic energy",
                                          "fluid's kinetic energy"};

std::string brief(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

}  // namespace

int beginning_to_leave(const std::vector<double>& values, double fine) {
  const int n = int(values.size());
  double all = 0;
  for (double y : values) all += y / n;
  // From the end: the sums are those of what is kept. The last few say nothing about their scatter.
  std::vector<double> error(n);
  double sum = 0, squares = 0;
  for (int leave = n - 1; leave >= 0; --leave) {
    const double y = values[leave] - all, kept = n - leave;
    sum += y, squares += y * y;
    error[leave] = (std::max(0.0, squares - sum * sum / kept) / kept + fine * fine) / kept;
  }
  const int most = n - std::max(5, n / 4);
  const double least = *std::min_element(error.begin(), error.begin() + most + 1);
  const auto best = std::find_if(error.begin(), error.end(), [&](double e) { return e <= StartUp::kNearly * least; });
  const int leave = int(best - error.begin());
  return leave > n / 3 ? n : leave;
}

std::array<double, 2> drift_of(const std::vector<double>& values, double fine) {
  const int n = int(values.size());
  double mean = 0, squares = 0, slope = 0, rest = 0;
  for (double y : values) mean += y / n;
  for (int i = 0; i < n; ++i) {
    const double t = i - 0.5 * (n - 1);
    squares += t * t, slope += t * (values[i] - mean);
  }
  slope /= squares;
  for (int i = 0; i < n; ++i) {
    const double r = values[i] - mean - slope * (i - 0.5 * (n - 1));
    rest += r * r;
  }
  // Round-off alone is no drift.
  const double scatter = std::max({std::sqrt(rest / (n - 2)), fine, kRoundOff * std::abs(mean) + 1e-300});
  return {std::abs(slope) * std::sqrt(squares) / scatter, std::abs(slope) * (n - 1) / scatter};
}

StartUp::StartUp(double longest) : longest_(longest) {
  state_.fine.assign(kFlowNumbers, 0.0);
  begin_series(0, 0);
}

void StartUp::begin_series(double time, double next_look) {
  state_.origin = time, state_.held = -1;
  state_.bins = 0, state_.bin_length = 1, state_.bin_samples = 0;
  state_.looks = 0, state_.next_look = next_look;
  state_.series.assign(std::size_t(kBins) * kColumns, 0.0);
}

void StartUp::begin_anew(double time) {
  state_.begun = -1;
  state_.fine.assign(kFlowNumbers, 0.0);
  begin_series(time, 0);
}

std::string StartUp::add(double time, double weight, const FlowNumbers& numbers) {
  StartUpState& s = state_;
  double* const row = bin(s.bins);
  for (int q = 0; q < kFlowNumbers; ++q) row[q] += weight * numbers[q];
  row[kFlowNumbers] += weight;
  if (++s.bin_samples < s.bin_length) return "";
  s.bin_samples = 0;
  if (++s.bins == kBins) {
    for (int b = 0; b < kBins / 2; ++b)
      for (int q = 0; q < kColumns; ++q) bin(b)[q] = bin(2 * b)[q] + bin(2 * b + 1)[q];
    std::fill(bin(kBins / 2), bin(0) + s.series.size(), 0.0);
    s.bins = kBins / 2;
    s.bin_length *= 2;
  }
  return over() ? look_for_drift(time) : look_for_end(time);
}

std::vector<double> StartUp::means_of(int number) const {
  std::vector<double> means;
  for (int b = 0; b < state_.bins; ++b) {
    const double* const row = state_.series.data() + std::size_t(b) * kColumns;
    means.push_back(row[number] / row[kFlowNumbers]);
  }
  return means;
}

/// So often the fluid has passed the longest side since the series began.
double StartUp::passes(double time) const {
  double energy = 0, weight = 0;
  for (int b = 0; b < state_.bins; ++b) {
    const double* const row = state_.series.data() + std::size_t(b) * kColumns;
    energy += row[kFlowFluidEnergy], weight += row[kFlowNumbers];
  }
  return (time - state_.origin) * std::sqrt(2 * energy / weight) / longest_;
}

int StartUp::left_of(int number, double time, double* fine) const {
  const std::vector<double> means = means_of(number);
  const auto [low, high] = std::minmax_element(means.begin(), means.end());
  const double rest = kRest * longest_ / (time - state_.origin);  // m/s
  const bool energy = number == kFlowSolidsEnergy || number == kFlowFluidEnergy;
  *fine = std::max({kFine * (*high - *low), kRoundOff * std::max(std::abs(*low), std::abs(*high)),
                    energy ? 0.5 * rest * rest : 0.0});
  return beginning_to_leave(means, *fine);
}

std::string StartUp::look_for_end(double time) {
  StartUpState& s = state_;
  if (s.bins < kLeastBins) return "";
  int left = 0;
  for (int q = 0; q < kFlowNumbers; ++q) left = std::max(left, left_of(q, time, &s.fine[q]));
  if (left == s.bins) {
    s.held = -1;
    return "";
  }
  if (s.held < 0) s.held = time;
  const double since = time - s.origin;
  if (s.held - s.origin > 0.8 * since || (passes_wanted_ && passes(time) < kPasses)) return "";
  s.begun = time;
  const double length = since * left / s.bins;
  begin_series(time, time + since);
  return "start-up lasted " + brief(length) + " s, means are taken from " + brief(time) + " s on";
}

std::string StartUp::why_not_over(double time) const {
  const StartUpState& s = state_;
  const std::string longer = "the run must be longer, or 'output average from' a time";
  if (s.bins < kLeastBins)
    return "it is looked for after " + std::to_string(kLeastBins) + " samples at couplings, and there are " +
           std::to_string(s.bins * s.bin_length + s.bin_samples) + ": " + longer;
  std::string changing, why;
  int numbers = 0;
  for (int q = 0; q < kFlowNumbers; ++q) {
    double fine = 0;
    if (left_of(q, time, &fine) < s.bins) continue;
    changing += (numbers++ == 0 ? "the " : " and the ") + std::string(kNames[q]);
  }
  const double since = time - s.origin, steady = s.held < 0 ? 0 : time - s.held;
  if (numbers > 0)
    why = changing + (numbers > 1 ? " still change" : " still changes");
  else if (steady < 0.2 * since)
    why = "the flow has been steady for " + brief(steady) + " s, of the fifth of " + brief(since) + " s that is wanted";
  const double passed = passes(time);
  if (passes_wanted_ && passed < kPasses)
    why += std::string(why.empty() ? "" : ", and ") + "the fluid has passed the domain's longest side " +
           brief(passed) + " of " + brief(kPasses) + " times" +
           (passed > 0.01 ? ", which takes some " + brief(since * (kPasses / passed - 1)) + " s more" : "");
  return (why.empty() ? "it is looked for again soon" : why) + ": " + longer;
}

std::string StartUp::look_for_drift(double time) {
  StartUpState& s = state_;
  if (s.bins % kGroups != 0 || s.bins < kLeastBins || time < s.next_look) return "";
  s.next_look = time + (time - s.origin);
  ++s.looks;
  for (int q = 0; q < kFlowNumbers; ++q) {
    const std::vector<double> means = means_of(q);
    std::vector<double> groups(kGroups, 0.0);
    for (int b = 0; b < s.bins; ++b) groups[b * kGroups / s.bins] += means[b] * kGroups / s.bins;
    const std::array<double, 2> drift = drift_of(groups, s.fine[q]);
    if (drift[0] <= kDrift || drift[1] <= 1) continue;
    const double before = s.begun, since = time - s.origin;
    s.begun = time;
    ++s.restarts;
    const std::string change = brief(means.front()) + " to " + brief(means.back());
    begin_series(time, time + since);
    return "the " + std::string(kNames[q]) + " has drifted since " + brief(before) + " s (from " + change +
           "): the means begin anew at " + brief(time) + " s";
  }
  return "";
}

}  // namespace twogrid
