// Steps in time for a wanted accuracy: the coupling interval and the fluid's Courant number, from errors that are
// measured now and then during the run (coupling.h, Report):
//   coupling error   half the jump of the fluid's forces on the particles at a coupling, over the forces: what holding
//                    them over the interval leaves open. Of first order in the interval. A suspension that falls from
//                    rest has 0.5 Delta/T of it and is wrong by 0.14 Delta/T (T its response time;
//                    cases/studies/coupling_interval): an upper bound of what the results feel.
//   step error       difference of the fluid's interval when taken in steps of half the length, times kMemory, the
//                    number of intervals whose errors add up. Of second order.
// Each is held at the wanted value by its own step, by means over kTogether checks. An error that doesn't fall when its
// step is shortened is noise of the method (particles crossing cells; deposit centroid): the longer step is taken
// again.
#pragma once

#include <string>

namespace twogrid {

/// One step length and the error that goes with it.
class StepControl {
 public:
  static constexpr int kTogether = 3;
  static constexpr int kPatience = 10;  ///< rounds of kTogether checks before shorter steps are tried again after noise

  StepControl() = default;
  /// order: of the error in the step; a step that is not free is only watched.
  StepControl(double wanted, double order, double step, bool free, double least, double most);

  void note(double error);
  /// From now on no longer than this.
  void limit(double most);
  double step() const { return step_; }
  bool noisy() const { return rounds_of_noise_ > 0; }                       ///< shortening the step didn't help
  double mean_error() const { return count_ ? sum_ / double(count_) : 0; }  ///< of all checks
  double shortest() const { return shortest_; }
  double longest() const { return longest_; }

  /// All that it has learned: f(name, entry), names after `begin`; limit() is called anew before each note(). S:
  /// StepControl or const StepControl.
  template <class S, class F>
  static void for_each_entry(S& s, const std::string& begin, F&& f) {
    f(begin + "step", s.step_), f(begin + "here", s.here_);
    f(begin + "sum_here", s.sum_here_), f(begin + "longer_step", s.longer_step_);
    f(begin + "error_of_longer", s.error_of_longer_), f(begin + "rounds_of_noise", s.rounds_of_noise_);
    f(begin + "count", s.count_), f(begin + "sum", s.sum_), f(begin + "shortest", s.shortest_);
    f(begin + "longest", s.longest_);
  }

 private:
  void decide(double error);

  double wanted_ = 0, order_ = 1, step_ = 1, least_ = 1, most_ = 1;
  bool free_ = false;
  int here_ = 0;                                  // checks at this step
  double sum_here_ = 0;                           // their errors
  double longer_step_ = 0, error_of_longer_ = 0;  // before the last shortening; 0: none
  int rounds_of_noise_ = 0;                       // to go
  long long count_ = 0;
  double sum_ = 0, shortest_ = 1, longest_ = 1;
};

class Accuracy {
 public:
  static constexpr int kChecked = 100;  ///< couplings between checks; a check costs 2 fluid intervals: 2 % at most
  static constexpr int kEarly = 10;     ///< couplings between the first 2 kTogether checks
  static constexpr int kLargestEvery = 100;
  static constexpr double kMemory = 10, kSmallestCfl = 0.05, kLargestCfl = 0.8;
  static constexpr double kLargestDragNumber = 0.85;

  Accuracy() = default;
  /// wanted: relative error, 0 for none; every: DEM steps to a coupling to begin with; free_...: may be changed.
  Accuracy(double wanted, int every, bool free_every, double cfl, bool free_cfl);

  bool on() const { return wanted_ > 0; }
  /// Whether the coupling to come is to be checked.
  bool due() const { return on() && couplings_ + 1 >= next_check_; }
  void count_coupling() { ++couplings_; }
  /// Takes the errors of a check and adjusts the steps. drag_number: interval over the shortest response time of a
  /// particle; it is kept below kLargestDragNumber, up to which the steady flow doesn't depend on the interval
  /// (coupling.cpp, complete_drag).
  void adjust(double step_error, double coupling_error, double drag_number);

  int every() const;
  double cfl() const { return fluid_.step(); }
  double wanted() const { return wanted_; }
  long long checks() const { return checks_; }
  const StepControl& fluid() const { return fluid_; }
  const StepControl& coupling() const { return coupling_; }

  /// Continuity error of the pressure solver (relative to U/h) that goes with a wanted accuracy.
  static double tolerance(double wanted);

  /// All that the checks so far leave to the next ones: f(name, entry). S: Accuracy or const Accuracy.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    StepControl::for_each_entry(s.fluid_, "fluid_", f), StepControl::for_each_entry(s.coupling_, "coupling_", f);
    f("couplings", s.couplings_), f("next_check", s.next_check_), f("checks", s.checks_);
  }

 private:
  double wanted_ = 0;
  StepControl fluid_, coupling_;
  long long couplings_ = 0, next_check_ = kEarly, checks_ = 0;
};

}  // namespace twogrid
