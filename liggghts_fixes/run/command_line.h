// The words after `twogrid`, shared out between LIGGGHTS and PETSc.
#pragma once

#include <string>
#include <vector>

namespace twogrid {

struct CommandLine {
  std::vector<std::string> liggghts;                ///< begins with the program's name
  std::vector<std::string> petsc;                   ///< likewise
  double plan = 0;                                  ///< -plan: seconds to measure for; 0: not asked for
  bool version = false;                             ///< -version was asked for
  bool keywords = false;                            ///< -keywords was asked for
  std::string restart;                              ///< -restart (with -in): a folder, or auto; empty: not asked for
  std::string script;                               ///< -in; empty: none
  std::string log = "log.liggghts";                 ///< -log
  std::vector<std::vector<std::string>> variables;  ///< -var: name, values
  std::string particles = "auto";                   ///< -particles: what evaluates contacts, see register_particles()
};

constexpr double kPlanSeconds = 8;  ///< of -plan without a number

/// LIGGGHTS' switches go to LIGGGHTS, which ends on one it doesn't know; PETSc's options, known by their beginnings
/// (-fluid_, -ksp_, -log_view, -options_, ...), go to PETSc. `-screen none` becomes `-screen /dev/null`, as LIGGGHTS'
/// fix insert/pack doesn't survive the former. `-restart NAME` beside `-in` is ours; LIGGGHTS' own, which takes two words and
/// turns a restart file into a data file, comes without a script. Throws std::invalid_argument with a sentence for anything else.
CommandLine split_command_line(const std::vector<std::string>& words);

}  // namespace twogrid
