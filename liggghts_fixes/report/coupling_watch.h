// What the report of a coupling says that a user should hear at once: one sentence each, with the remedy, when a figure
// first goes over its limit and again each time it has doubled since. Pure functions: no LIGGGHTS, no MPI.
#pragma once

#include <string>
#include <vector>

#include "coupling/control/schedule.h"
#include "coupling/coupling.h"

namespace twogrid {

class CouplingWatch {
 public:
  /// Particle cells that a particle may cross in a coupling interval: beyond, a bed's means change (tests/stability).
  static constexpr double kTravel = 0.3;
  /// Response times that an interval may last with 'hold off': a periodic suspension swings up from 0.3 to 0.35 of them on
  /// (settling.py; held fluxes have no such limit).
  static constexpr double kUnheld = 0.3;
  static constexpr double kMoved = 0.01;  ///< of the solids' volume may be moved (or thrown away) by the eps bound
  static constexpr double kError = 1e-9;  ///< relative error of solid volume and momentum: round-off lies far below

  /// With 'dt' nothing keeps the Courant number small: above the first, convection is stable only where drag damps
  /// it, and that is told; above the second a run is beyond help.
  static constexpr double kCourant = 1, kMostCourant = 1000;

  CouplingWatch() = default;
  explicit CouplingWatch(const Settings& settings)
      : bound_(settings.bound),
        eps_min_(settings.eps_min),
        unheld_(settings.hold_flux == Choice::kOff && !settings.one_way),
        dt_(settings.fluid.convection == Convection::kNone ? 0.0 : settings.fluid.dt) {}

  /// Throws std::runtime_error with a sentence where the Courant number is out of hand. After a coupling over `steps` DEM steps of dem_dt seconds; steps 0: the first deposit. Usually no sentence.
  std::vector<std::string> look(const Report& report, int steps, double dem_dt);

  /// What has been told, but for errors, which are worth a second word: f(name, entry). S: CouplingWatch or const CouplingWatch.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("travel", s.travel_.at), f("moved", s.moved_.at), f("unplaced", s.unplaced_.at);
    f("courant", s.courant_.at);
  }

 private:
  /// Whether a figure is over its limit, and twice what was last told.
  struct Told {
    double at = 0;
    bool due(double value, double limit);
  };
  EpsBound bound_ = EpsBound::kMove;
  double eps_min_ = 0;
  bool unheld_ = false;
  double dt_ = 0;
  Told courant_, drag_, travel_, moved_, unplaced_, behind_, volume_, momentum_;
};

/// At a coupling. now: particles of all ranks, less those that were inserted so far, so that it only falls. most: of
/// `most_lost`; negative: off. Returns a warning where one is due, else "". Throws std::runtime_error with a sentence
/// where more are lost.
std::string losses(Schedule& schedule, long long now, long long most, long long step);

}  // namespace twogrid
