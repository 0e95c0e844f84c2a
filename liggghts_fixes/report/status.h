// status.json beside the log: what a run is doing, for whoever watches it from outside (a batch script, a monitor). It
// is rewritten whole, beside the old one, and put in its place: a reader never finds half of it. What can't be written
// is left out in silence, for a run must not end for want of its status. No LIGGGHTS.
#pragma once

#include <mpi.h>

#include <chrono>
#include <string>

#include "coupling/control/schedule.h"
#include "coupling/report.h"

namespace twogrid {

/// All that the file holds. Numbers that are not known, or not finite, are null in it.
struct RunStatus {
  static constexpr double kUnknown = -1;

  std::string state = "running";  ///< then "finished", "ended by signal N" or "error"
  std::string error;              ///< its sentence
  std::string program, started, date;
  int ranks = 1;
  long long step = 0, first_step = 0, last_step = -1;  ///< of the run in hand; last_step -1: not known
  bool running = false;                                ///< a `run` is in hand
  double wall = 0;                                     ///< s since the program began
  double steps_per_second = kUnknown;
  double wall_per_simulated = kUnknown;  ///< s of wall clock for a s of the fluid's time
  double to_go = kUnknown;               ///< s of wall clock to the end of the run in hand
  bool fluid = false;                    ///< the following is known
  Report report;
  long long particles = -1, lost = 0;       ///< of all ranks; particles -1: not known
  std::string checkpoint, checkpoint_date;  ///< the last one's path; empty: none yet
  long long checkpoint_step = 0;
};

/// As JSON.
std::string status_json(const RunStatus& status);

/// "log.liggghts" -> "status.json", "out/other.log" and "out/log.other" -> "out/other.status.json", "none" -> "" (no log,
/// no status).
std::string status_name(const std::string& log);

class Status {
 public:
  /// The one of this process: main(), commands and fixes tell it what they know.
  static Status& of_process();

  /// s between files; the first of a run come sooner, each twice as long after the one before.
  static constexpr double kFirst = 1, kSeconds = 60;
  /// A script of many short runs doesn't write one for every beginning and end: after so many, at most one in kPause s.
  static constexpr int kManyRuns = 100;
  static constexpr double kPause = 0.2;

  /// From here on there is a file. path: empty for none. Only rank 0 writes it, but for an error of another one.
  void open(const std::string& path, const std::string& program, int rank, int ranks);
  /// A `run` from step `first` to `last` begins, or goes on from a checkpoint, at `step`.
  void begin_run(long long step, long long first, long long last);
  /// The run in hand ends at `step`, if not before.
  void end_at(long long step);
  /// The run has come to `step`: writes when it is time.
  void step(long long step);
  /// A coupling is done, at `step`; inserted: particles, of the run so far, which the schedule's count is without. Writes
  /// when it is time.
  void couple(long long step, const Report& report, const ScheduleState& schedule, long long inserted);
  void end_run(long long step);
  void checkpoint(const std::string& path, long long step);
  void finish();
  void end_by_signal(int number, const std::string& sentence = "");
  /// Nothing is written after an end. All ranks fail; or one alone, whichever, and ends the others.
  void fail(const std::string& sentence);
  void fail_alone(const std::string& sentence);

  const RunStatus& now() const { return status_; }

 private:
  using Clock = std::chrono::steady_clock;
  void measure_rate(Clock::time_point now);
  void write_of_run();
  void write(bool any_rank = false);
  void end(const std::string& state, const std::string& sentence, bool any_rank = false);

  std::string path_;
  int rank_ = 0;
  bool ended_ = false;
  RunStatus status_;
  Clock::time_point began_, next_, mark_;  // mark: where the rate was last measured from
  double wait_ = kFirst;                   // s to the file after the next
  int runs_ = 0;                           // begun or ended
  long long mark_step_ = 0;
  double mark_time_ = 0;
};

/// The process' status, beside the log of that name. Local.
void open_status(const std::string& log, const std::string& program, MPI_Comm comm);

}  // namespace twogrid
