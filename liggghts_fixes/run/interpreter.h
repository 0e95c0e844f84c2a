// The reader of the script, in place of LIGGGHTS' own loop over its lines: it executes the same commands in the same
// order, and knows where it stands (ResumePoint), so that another process can go on from there.
//
// `if` is taken apart here: the commands that it chooses come before the next line. What is remembered are commands as
// they were executed, their variables replaced: what a script asks of the particles on its way (`if "$(count(all)) > 5"`)
// is not asked again.
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/run/resume_point.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class Interpreter {
 public:
  /// script: file of -in; empty: read from the standard input. variables: of the command line. Both as given.
  Interpreter(LAMMPS_NS::LAMMPS& lammps, std::string script, std::vector<std::vector<std::string>> variables);

  /// Executes lines until the script ends (or says `quit`), or until stop() says so after a command. Collective.
  void run(const std::function<bool()>& stop);
  /// Executes one line, and what an `if` in it chooses.
  void one(const std::string& line);

  /// A run has been made: what is said again after it is said to fixes that have run.
  void note_run();
  /// Called by go_on_from() in place of runs.
  void on_run(std::function<void()> f) { on_run_ = std::move(f); }

  bool from_file() const { return !script_.empty(); }
  const std::string& script() const { return script_; }
  /// What would be said again: fixes, dumps, variables, ...
  const std::vector<Command>& commands() const { return done_; }
  /// The script's place in rank 0; empty in the others. The run, if one is in hand, is the caller's to add.
  ResumePoint here() const;
  /// Executes what the script has done up to there, but for what acts on particles; the box comes from the restart file
  /// `particles`. Then the script stands behind its line in hand. Throws std::invalid_argument with a sentence where the
  /// script's text up to there, or a variable of the command line, is another. Returns the line in hand, if the script
  /// now has another one there; else "". Collective.
  std::string go_on_from(const ResumePoint& point, const std::string& particles);
  /// The words of a line after substitution, not executed.
  Command words_of(const std::string& line);

 private:
  bool next_line(std::string& line);
  void execute(const std::string& line);
  void execute_parsed();
  void choose();
  bool leave_out(const Command& command) const;
  void end_script();
  void again(Command command, const std::string& particles);
  std::string open_files(const ResumePoint& point);
  /// Of rank 0; throws on all ranks.
  void agree(const std::string& sentence) const;

  LAMMPS_NS::LAMMPS& lammps_;
  std::string script_;
  std::vector<std::vector<std::string>> variables_;
  std::function<void()> on_run_;
  std::vector<int> masks_;  // groups of this rank's particles, as the restart file has them
  bool quits_ = false;
  std::deque<std::string> pending_;
  std::vector<Command> done_;
  // Rank 0's.
  std::vector<std::string> names_;  // of the files that are open
  std::string line_;                // in hand, as it is written; empty where it came from an `if`
  long begin_ = 0;                  // where it begins
};

}  // namespace twogrid
