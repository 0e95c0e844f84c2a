// What fix twogrid says while it runs: warnings of the scene and of each coupling, particles that vanish, progress, and
// signals. On screen and in the log, by rank 0.
#pragma once

#include <string>
#include <vector>

#include "coupling/control/schedule.h"
#include "liggghts_fixes/report/coupling_watch.h"
#include "liggghts_fixes/report/progress.h"
#include "liggghts_fixes/run/petsc_session.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class RunWatch {
 public:
  /// id: of the fix.
  RunWatch(LAMMPS_NS::LAMMPS& lammps, std::string id) : lammps_(lammps), id_(std::move(id)) {}

  void say(const std::string& text) const;
  void warn(const std::string& text) const;
  /// Warnings of the scene that have been said before, elsewhere.
  void have_said(std::vector<std::string> warnings) { said_ = std::move(warnings); }
  /// Warns of those that have not been said.
  void warn_of_news(const std::vector<std::string>& warnings);
  /// Options of the command line that begin so, not the others, and that nothing has asked for: misspelt, most likely.
  void warn_of_unused_options(const std::string& beginning, const std::string& but);

  void look_at(const CouplingWatch& coupling) { coupling_ = coupling; }
  CouplingWatch& coupling() { return coupling_; }
  /// A run of so many DEM steps begins: particles are counted. Collective.
  void begin_run(long long steps, Schedule& schedule);
  /// Before a coupling, one small message: have particles vanished? Throws where more have than most_lost (negative: any
  /// number may). Collective.
  void look(Schedule& schedule, long long most_lost) const;
  /// The coupling begins.
  void begin_coupling();
  /// Between its fluid steps, so many of which are this share of the interval: progress, and signals that can't wait for
  /// its end. Collective. Throws.
  void look_within(int steps, double share, double time);
  /// What the last coupling's report should not go on without.
  void look(const Report& report, int steps);
  /// After a coupling, `done` steps into the run: on screen and in status.json, where it is time.
  void tell_progress(long long done, const Report& report, Schedule& schedule);

 private:
  LAMMPS_NS::LAMMPS& lammps_;
  std::string id_;
  std::vector<std::string> said_;
  CouplingWatch coupling_;
  UnusedOptions unused_options_;
  Progress progress_;
  double coupling_begin_ = 0;  // wall clock
};

}  // namespace twogrid
