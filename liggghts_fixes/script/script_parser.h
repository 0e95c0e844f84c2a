// The words of `fix ID group twogrid ...` and `fix_modify ID ...` turned into settings. Pure functions: no LIGGGHTS, no
// MPI. Every function throws std::invalid_argument with one sentence that holds the keyword, what was found and what is
// wanted.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "coupling/settings.h"

namespace twogrid {

/// Three components as a script gives them: numbers, or LIGGGHTS equal-style variables (v_NAME).
struct ScriptedVelocity {
  Vec3 number{0, 0, 0};                 ///< m/s
  std::array<std::string, 3> variable;  ///< name without v_; empty: the number holds
  bool is_constant() const { return variable[0].empty() && variable[1].empty() && variable[2].empty(); }
};

/// What belongs to a condition and can only be resolved inside LIGGGHTS. Parallel to FluidSettings::side.
struct ConditionNames {
  ScriptedVelocity velocity;
  std::string region;  ///< id of the patch's region; empty: none
};

/// A script so far.
struct Script {
  Settings settings;
  bool domain_given = false;
  bool every_auto = false;
  std::array<bool, 6> side_given{};  ///< the whole side's condition was stated
  std::array<std::vector<ConditionNames>, 6> names;
};

/// The simulation box as far as it concerns the fluid.
struct BoxFacts {
  std::array<double, 6> bounds{};  ///< xlo xhi ylo yhi zlo zhi (m)
  std::array<bool, 3> periodic{};
};

/// words: what follows `fix ID group twogrid`.
///   fine nx ny nz, ratio rx ry rz, domain xlo xhi ylo yhi zlo zhi, density rho, viscosity mu, every N|auto,
///   stretch x|y|z [symmetric] G (each cell is G times as wide as the one before; symmetric: finest at both ends)
Script parse_fix(const std::string& id, const std::vector<std::string>& words);

/// words: what follows `fix_modify ID`; several keywords may follow each other. started: a run has taken place, so that
/// only the velocities of inlets and walls and the times of output may still change.
void parse_fix_modify(Script& script, const std::vector<std::string>& words, bool started);

/// Fills in what the box says (domain, periodic sides) and checks what concerns several keywords: domain inside the
/// box, sides of periodic directions, lengths against cells, and all that FluidSettings::check looks at.
void complete(Script& script, const BoxFacts& box);

/// LIGGGHTS' boundary codes (0 p, 1 f, 2 s, 3 m; [direction][lo, hi]): s and m move the box at every rebuild and are
/// refused, with the line to write instead.
void check_box_boundary(const int boundary[3][2]);

/// The fine grid of complete settings.
FineGrid fine_grid(const Settings& settings, const std::array<bool, 3>& periodic);
/// Directions whose two sides are periodic.
std::array<bool, 3> periodic_directions(const FluidSettings& fluid);

}  // namespace twogrid
