// How large the files of a script that is only planned will be: from what one frame, one line or one restart file takes,
// and how many there will be.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/report/plan_table.h"
#include "liggghts_fixes/run/resume_point.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class PlannedFiles {
 public:
  /// script: its name, beside which checkpoints lie.
  PlannedFiles(LAMMPS_NS::LAMMPS& lammps, std::string script) : lammps_(lammps), script_(std::move(script)) {}

  /// At the end of what was made of a run, before its last step: dumps write in it, so that their size is known.
  void ask_dumps();
  /// After it. Collective.
  void measure_dumps();
  /// A run from step `from` to `to` has been passed; commands: that have made fixes. Collective.
  void count(long long from, long long to, const std::vector<Command>& commands);
  /// CPU s of frames of the fixes twogrid so far, as if all had been written.
  double take_seconds();
  /// All files. Collective; of rank 0.
  std::vector<PlannedFile> list() const;

 private:
  struct Kind {
    double begin = 0, piece = 0;  // bytes: before the first piece; of a piece
    double pieces = 0;
    std::string what;
  };
  Kind& kind(const std::string& name, const std::string& what);
  void count_frames(long long from, long long to);
  void count_dumps(long long from, long long to);
  void count_restarts(long long from, long long to, const std::vector<Command>& commands);
  void count_tables(long long from, long long to, const std::vector<Command>& commands);
  void count_checkpoints();
  void count_log(long long from, long long to, const std::vector<Command>& commands);

  LAMMPS_NS::LAMMPS& lammps_;
  std::string script_;
  std::map<std::string, Kind> kinds_;            // by the file's name
  std::map<std::string, double> before_;         // size of dumps' files before their last frame
  std::map<std::string, long long> next_frame_;  // of output files
  double seconds_ = 0;
};

}  // namespace twogrid
