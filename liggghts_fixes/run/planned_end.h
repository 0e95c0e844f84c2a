// The end of a run whose means are as sure as `output average until` wants.
#pragma once

namespace twogrid {

/// Kept between two runs; for_each_entry() walks it by name, as CouplingState's does.
struct PlannedEnd {
  long long step = 0;    ///< at which the run is to end; 0: not known
  bool reached = false;  ///< it has ended: later runs go on to their own ends

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("step", s.step), f("reached", s.reached);
  }
};

}  // namespace twogrid
