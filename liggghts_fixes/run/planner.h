// A script that is only planned (-plan): every `run` is set up as it is, but made for a moment only, and measured; then the
// step is set to where the run would have ended, and the script goes on. Files are still meanwhile (still_files.h).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "liggghts_fixes/report/plan_table.h"
#include "liggghts_fixes/report/planned_bed.h"
#include "liggghts_fixes/run/contact_costs.h"
#include "liggghts_fixes/run/planned_files.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// What a run's moment didn't show.
struct MissingWork {
  double contacts = 0, particles = 0;  ///< times DEM steps, of the fullest rank
  double builds = 0;                   ///< of the neighbour lists, times particles of the fullest rank
};

class Planner {
 public:
  /// script: its name, for the plan. seconds: of measuring, for all runs.
  Planner(LAMMPS_NS::LAMMPS& lammps, const std::string& script, double seconds);

  /// Has LIGGGHTS' time integration (run_style verlet) measure, and end early. Before the run's init().
  void let_runs_be_measured();
  /// A run begins: its line. Its parts follow (one, but for `every`).
  void begin_run(const std::string& line);
  /// Before and after LIGGGHTS' command `run` for a part that is to end at step `to`; the step is then there. Collective.
  void begin_part(long long to);
  /// commands: that have made fixes so far.
  void end_part(long long to, const std::vector<Command>& commands);
  /// After the last part. Collective.
  void end_run();
  /// The script goes on for too long: a loop that waits for results, most likely. Collective.
  bool has_enough() const;
  /// The script has come to its end, or (stopped) has not. Tells the plan. Collective.
  /// execute: a line of a script, after which what there is in LIGGGHTS is gone.
  void finish(bool stopped, const std::function<void(const std::string&)>& execute);

  /// In place of LIGGGHTS' loop over n steps: advance(m) makes m of them, and end(m) the same, as the last ones of the run.
  using Steps = std::function<void(int)>;
  void measure(int n, const Steps& advance, const Steps& end);

 private:
  struct Times {
    double cpu = 0, deposit = 0, map = 0, fluid = 0, output = 0;
    long long step = 0, fluid_steps = 0, builds = 0;
  };
  Times now() const;
  double most_of_ranks(double value) const;
  int interval() const;
  void take_scene(PlannedRun& run);
  void look_at_bed();
  void look_ahead(long long step);

  LAMMPS_NS::LAMMPS& lammps_;
  double seconds_;
  Plan plan_;
  PlannedFiles files_;
  double began_ = 0, spent_ = 0;      // s of wall clock: at the beginning; of loops so far
  double between_ = 0;                // CPU s when the part before was done
  double coming_ = 0;                 // particles that there would be by now, beyond those that there are
  double fallen_ = 0;                 // s that those that are there have had to fall
  double particles_ = 0;              // at the end of the run before
  bool stale_ = false;                // particles hang where they would have fallen
  std::vector<MissingWork> missing_;  // of each run
  std::vector<Command> scene_;        // commands of the last scene with particles
  PlannedSpheres spheres_;            // in it

  // Of the part in hand.
  long long part_end_ = 0;
  std::vector<std::string> insertions_;  // that are done in it
  PlannedBed bed_;                       // as the fluid carries it
  double contacts_ = 0;                  // of this rank
  double fall_ = 0;                      // s that particles would fall for
  Times part_, loop_, from_, to_,
      end_;  // CPU and the like: of its begin; of its loop's begin; measured; of the loop's end
};

}  // namespace twogrid
