// When a run couples, when it writes a frame, and whether particles have vanished in between. All that a run knows of
// this from one DEM step to the next is ScheduleState. Pure counting: no LIGGGHTS, no MPI.
#pragma once

namespace twogrid {

/// What a step leaves to the next. for_each_entry() walks by name what is kept
/// between two runs, as CouplingState's does: `interval` is known anew at every coupling, `particles` in every run.
struct ScheduleState {
  int steps = 0;                 // DEM steps that the particles have run since the last coupling
  double time = 0;               // of these steps (s)
  double interval = 0;           // of the last coupling (s)
  long long next_frame = 0;      // step from which on a frame is due
  long long particles = -1;      // of all ranks at the last coupling of this run; -1: none yet
  long long lost = 0, told = 0;  // particles that have vanished; of these, told in a warning

  /// Calls f(name, entry) for every entry, in an order that is always the same; entry: int&, long long& or double&.
  /// S: ScheduleState or const ScheduleState.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("steps", s.steps), f("time", s.time), f("next_frame", s.next_frame), f("lost", s.lost), f("told", s.told);
  }
};

class Schedule {
 public:
  Schedule() = default;
  /// every_changes: `every` is chosen anew during the run, and couplings go by the steps since the last one. Else they
  /// fall on its multiples, of the absolute step number, so that run boundaries don't shift the phase.
  explicit Schedule(bool every_changes) : every_changes_(every_changes) {}

  /// A run is set up: commands since the last one may have deleted particles.
  void begin_run() { state_.particles = -1; }
  /// The particles have run step number `step`, of dt seconds. From now to end_step(), coupling() says whether it ends
  /// with a coupling.
  void count_step(long long step, double dt, int every);
  bool coupling() const { return coupling_; }
  void end_step() { coupling_ = false; }

  int steps() const { return state_.steps; }  ///< since the last coupling; 0 at a coupling, once it is done
  double mean_dt() const { return state_.time / state_.steps; }  ///< of these steps (s)
  /// The coupling over these steps is done.
  void end_interval();
  double interval() const { return state_.interval; }  ///< of the last coupling (s)

  /// A frame in every `every` steps (0: none) is due at the first coupling from their multiple on.
  bool frame_due(long long step, long long every) const { return every > 0 && step >= state_.next_frame; }
  void frame_written(long long step, long long every) { state_.next_frame = (step / every + 1) * every; }

  /// `now`: particles of all ranks at a coupling. Returns how many have vanished within runs so far, if that is to be
  /// told: at first, and whenever it has more than doubled since; else 0.
  long long count_particles(long long now);

  ScheduleState& state() { return state_; }

 private:
  bool every_changes_ = false;
  bool coupling_ = false;
  ScheduleState state_;
};

}  // namespace twogrid
