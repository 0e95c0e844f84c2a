// When a run's start-up is over (`output average from auto`), and whether the flow drifts afterwards.
//
// Of the whole flow a few numbers are followed: pressure drop, height and kinetic energy of the solids, kinetic energy of
// the fluid; each as means over 64 to 128 bins of equally many samples (two become one when there are 128).
//
//   over    For each number the beginning is found that, left away, makes the standard error of the mean of the rest least
//           (MSER; White 1997, Simulation 69, 323; of bins as by White, Cobb & Spratt 2000): the shortest one whose error is
//           at most kNearly times the least, at least a fourth of the bins being kept. kFine of what the number has gone
//           through counts as scatter, too, as do round-off and speeds of kRest of the domain's side in all that time: what comes
//           to rest would never be at rest enough. Start-up is over when none of these
//           beginnings is longer than a third of the time, that was so for the last fifth of it, and the fluid has passed the
//           domain's longest side kPasses times, unless nothing drives it through (want_passes()).
//   drift   From then on the bins of the means' time are put together to 8; a number drifts when a straight line through
//           its 8 means rises by more than kDrift times its own standard error, and by more than their scatter about it.
//           Looked at when that time is as long as start-up was, and whenever it has doubled: means that hold a drift
//           begin anew.
//   anew    Where a run begins with other conditions of the flow than the one before ended with, all of this does.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace twogrid {

/// The numbers followed, of all ranks.
enum FlowNumber { kFlowPressureDrop, kFlowSolidsHeight, kFlowSolidsEnergy, kFlowFluidEnergy, kFlowNumbers };
using FlowNumbers = std::array<double, kFlowNumbers>;

/// A copy is a checkpoint; for_each_entry() walks it by name, as CouplingState's does.
struct StartUpState {
  double begun = -1;          // time from which means are taken (s); negative: start-up
  double origin = 0;          // time at which the series begins (s)
  double held = -1;           // time since which the beginnings have been short (s); negative: they are not
  int bins = 0;               // full ones
  long long bin_length = 1;   // samples
  long long bin_samples = 0;  // in the one being filled
  double next_look = 0;       // for a drift (s)
  int looks = 0;              // for a drift, of this series
  int restarts = 0;
  std::vector<double> fine;    // of each number, scatter that doesn't count; of start-up
  std::vector<double> series;  // a row a bin, kFlowNumbers sums and their weight (s)

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("begun", s.begun), f("origin", s.origin), f("held", s.held), f("bins", s.bins), f("bin_length", s.bin_length);
    f("bin_samples", s.bin_samples), f("next_look", s.next_look), f("looks", s.looks), f("restarts", s.restarts),
        f("fine", s.fine), f("series", s.series);
  }
};

class StartUp {
 public:
  static constexpr int kBins = 128;
  static constexpr double kPasses = 5, kNearly = 1.1, kFine = 1e-3, kRest = 1e-3, kDrift = 6;

  /// longest: side of the fluid's domain (m).
  explicit StartUp(double longest);

  /// A sample of the flow at `time` (s) that stands for `weight` s. Returns a sentence where it changes the beginning of
  /// the means, which is then now. The same on all ranks if the numbers are.
  std::string add(double time, double weight, const FlowNumbers& numbers);
  bool over() const { return state_.begun >= 0; }
  /// Whether the fluid is to pass the domain before start-up is over: from now on. A fluid that nothing drives through never does.
  void want_passes(bool wanted) { passes_wanted_ = wanted; }
  /// A start-up begins.
  void begin_anew(double time);
  bool has_samples() const { return over() || state_.bins > 0 || state_.bin_samples > 0; }
  /// What start-up waits for, in words, with what would help. time: now (s).
  std::string why_not_over(double time) const;
  double begun() const { return state_.begun; }
  /// Whether means have been taken for long enough to tell a drift: as long as start-up was.
  bool has_looked() const { return state_.looks > 0; }
  /// When that is (s).
  double next_look() const { return state_.next_look; }
  StartUpState& state() { return state_; }

 private:
  static constexpr int kColumns = kFlowNumbers + 1;

  double* bin(int b) { return state_.series.data() + std::size_t(b) * kColumns; }
  void begin_series(double time, double next_look);
  std::vector<double> means_of(int number) const;
  /// The beginning of a number's series to leave away, now; fine: scatter that doesn't count.
  int left_of(int number, double time, double* fine) const;
  double passes(double time) const;
  std::string look_for_end(double time);
  std::string look_for_drift(double time);

  double longest_;
  bool passes_wanted_ = true;
  StartUpState state_;
};

/// How many of the first values are best left away (MSER); values.size() where the best would be more than a third of them.
/// fine: scatter that is there in any case.
int beginning_to_leave(const std::vector<double>& values, double fine);
/// Slope of a straight line through the values over its standard error, and its rise over their scatter about it, which is
/// at least `fine`.
std::array<double, 2> drift_of(const std::vector<double>& values, double fine);

}  // namespace twogrid
