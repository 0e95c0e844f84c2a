// What `fix ID group twogrid ...` and `fix_modify ID ...` have said so far. Plain values.
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
  std::string table;   ///< file of the inlet's profile; empty: none
};

/// Checkpoints that are written during runs (liggghts_fixes/run/checkpoint_folder.h).
struct CheckpointPlan {
  long long every = 0;  ///< DEM steps; 0: not by steps
  double seconds = 0;   ///< by the clock; 0: not by the clock
  std::string folder;   ///< empty: the default
  int keep = 2;         ///< how many are kept

  bool by_itself() const { return every > 0 || seconds > 0; }
};

/// A vessel or body in the fluid, by the name of what it is in LIGGGHTS (liggghts_fixes/bodies/).
struct BodyNames {
  enum class Kind { kMesh, kWall, kRegion };
  std::string name;
  Kind kind = Kind::kMesh;
  std::string id;  ///< of the fix mesh/surface, the fix wall/gran or the region
  bool slip = false;
  bool sheet = false;          ///< a mesh with fluid on both sides
  std::vector<Vec3> fluid_at;  ///< m; empty: not given
  bool blows = false;          ///< gas into the fluid
  double blow = 0;             ///< m/s
  std::string blow_variable;   ///< name without v_, in its place; empty: the number holds
  std::string blow_region;     ///< id of the region with the part that blows; empty: all
};

/// A script so far.
struct Script {
  Settings settings;
  bool domain_given = false;
  bool every_auto = false;
  std::array<bool, 3> fine_auto{}, ratio_auto{};  ///< the settings' numbers are 0 until they are chosen (grid_choice.h)
  std::vector<std::string> choices;               ///< what `auto` has chosen and why, lines of the scene report
  double chosen_for = 0;                          ///< particle cells were, for particles up to this diameter (m)
  bool end_told = false;                          ///< among them, that a bed lacks drag where it ends
  bool grids_auto() const { return fine_auto != std::array<bool, 3>{} || ratio_auto != std::array<bool, 3>{}; }
  std::string checkpoint_read, checkpoint_write;  ///< files; empty: not asked for
  CheckpointPlan checkpoints;
  long long most_lost = -1;          ///< particles that may vanish before the run ends; -1: any number
  std::array<bool, 6> side_given{};  ///< the whole side's condition was stated
  std::array<std::vector<ConditionNames>, 6> names;
  std::vector<BodyNames> bodies;
};

/// The simulation box as far as it concerns the fluid.
struct BoxFacts {
  std::array<double, 6> bounds{};  ///< xlo xhi ylo yhi zlo zhi (m)
  std::array<bool, 3> periodic{};
};

}  // namespace twogrid
