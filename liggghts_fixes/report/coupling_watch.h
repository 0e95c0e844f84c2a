// What the report of a coupling says that a user should hear at once: one sentence each, with the remedy, when a figure
// first goes over its limit and again each time it has doubled since. Pure functions: no LIGGGHTS, no MPI.
#pragma once

#include <string>
#include <vector>

#include "coupling/coupling.h"

namespace twogrid {

class CouplingWatch {
 public:
  /// Particle cells that a particle may cross in a coupling interval: beyond, a bed's means change (tests/stability).
  static constexpr double kTravel = 0.3;
  static constexpr double kMoved = 0.01;  ///< of the solids' volume may be moved (or thrown away) by the eps bound
  static constexpr double kError = 1e-9;  ///< relative error of solid volume and momentum: round-off lies far below

  CouplingWatch() = default;
  CouplingWatch(EpsBound bound, double eps_min) : bound_(bound), eps_min_(eps_min) {}

  /// After a coupling over `steps` DEM steps of dem_dt seconds; steps 0: the first deposit. Usually no sentence.
  std::vector<std::string> look(const Report& report, int steps, double dem_dt);

  /// What has been told: f(name, entry). S: CouplingWatch or const CouplingWatch.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("travel", s.travel_.at), f("moved", s.moved_.at), f("unplaced", s.unplaced_.at), f("volume", s.volume_.at);
    f("momentum", s.momentum_.at);
  }

 private:
  /// Whether a figure is over its limit, and twice what was last told.
  struct Told {
    double at = 0;
    bool due(double value, double limit);
  };
  EpsBound bound_ = EpsBound::kMove;
  double eps_min_ = 0;
  Told travel_, moved_, unplaced_, volume_, momentum_;
};

}  // namespace twogrid
