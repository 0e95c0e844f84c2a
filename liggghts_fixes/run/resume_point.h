// Where a script stands while a checkpoint is written, and what it has said up to there: all that another process needs
// to stand at the same place without doing again what the script did. Plain values; no LIGGGHTS, no MPI.
#pragma once

#include <string>
#include <vector>

namespace twogrid {

/// A command after the substitution of its variables: its name and its words.
using Command = std::vector<std::string>;

/// A script's file that is open: the script itself, and those that it includes.
struct OpenScript {
  std::string name;
  long at = 0;       ///< bytes of it that have been done
  std::string text;  ///< checksum of these bytes
};

struct ResumePoint {
  std::vector<std::vector<std::string>> variables;  ///< of the command line: name, values
  std::vector<OpenScript> files;                    ///< the innermost is the last
  std::string line;                                 ///< the line in hand, as it is written; empty: done
  std::vector<std::string> pending;                 ///< commands of an `if` that come before the next line
  bool jump_skip = false;                           ///< the next `jump` is not taken (`next` has come to its end)
  std::vector<Command> done;                        ///< commands to say again
  // The run in hand; run empty: none.
  Command run;
  long long begin = 0, end = 0;  ///< its first and last step
  // Where the run stands.
  long long step = 0;
  double time = 0;  ///< LIGGGHTS' own clock (s)
  long long particles = 0;
};

/// As text, and back. Throws std::invalid_argument where the text is something else.
std::string to_text(const ResumePoint& point);
ResumePoint resume_point(const std::string& text);

/// Whether a command belongs to what another process says again: what sets up, not what acts on particles, writes
/// files or moves the script's place. is_style: LIGGGHTS keeps it in its table of styles, not in its interpreter: all of
/// these but a few act on particles.
bool is_said_again(const Command& command, bool is_style);
/// `clear` forgets all but variables and the like.
void forget_scene(std::vector<Command>& done);

}  // namespace twogrid
