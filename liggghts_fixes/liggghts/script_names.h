// Names in the script that only LIGGGHTS can resolve: variables and regions of boundary conditions.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cfd/grid/grid.h"
#include "liggghts_fixes/report/scene_numbers.h"
#include "liggghts_fixes/script/script.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Of the flow, as a run has it at its beginning or end: a velocity, a pressure. Of a variable that hangs on more than the
/// step its formula counts, as a number without meaning.
struct FlowCondition {
  std::string name;
  double value = 0;
  bool formula = false;
};

/// What differs, as a sentence's beginning: the first one's name with both values; empty: nothing.
std::string change_of(const std::vector<double>& before, const std::vector<FlowCondition>& now);

class ScriptNames {
 public:
  /// script: of the fix of this id; it must live as long, and is written to.
  ScriptNames(LAMMPS_NS::LAMMPS& lammps, Script& script, const std::string& id)
      : lammps_(lammps), script_(script), id_(id) {}

  /// Variables and regions, by name in the script, become functions in the settings. Throws std::invalid_argument where
  /// there are none of that name.
  void resolve();
  /// What resolve() has found, for a fluid that lives already: regions may have been made anew.
  void renew(FluidSettings& fluid) const;
  /// Patches keep the faces that they had in the fix's first run: a region that has since been made anew must have the
  /// same. Throws std::invalid_argument.
  void check_region_faces(const FineGrid& grid);
  /// A run has been set up: LIGGGHTS has its list of computes that a variable may ask for.
  void run_is_set_up() { in_run_ = true; }
  /// For a plan: velocities of couplings are those of a later step of the run. 0: of the step itself.
  void look_ahead(long long step) { later_ = step; }
  /// What inlets and bodies that blow reach in the run that is being initialised. Variables that hang on nothing but the step
  /// (numbers, functions, ramp, other such variables) are looked at along it.
  InletsAhead ahead() const;
  /// All of the flow's, now: of the sides, the bodies that blow, and of what drives it. Always as many.
  std::vector<FlowCondition> conditions() const;
  /// Whether anything drives the fluid through the domain in the run that is being set up, or a wall moves it.
  bool drives_flow() const;
  /// Value of a variable, now. Throws std::invalid_argument, naming the keyword, where it is none.
  double equal_style(const std::string& variable, const std::string& keyword) const;

 private:
  bool hangs_on_step(const std::string& variable, int depth = 0) const;
  std::string formulas(const std::string& variable, int depth = 0) const;
  FlowCondition condition(const std::string& name, const std::string& variable, double number) const;
  double largest_ahead(const std::string& variable, const std::string& keyword) const;
  Vec3 velocity_now(int side, std::size_t condition) const;

  LAMMPS_NS::LAMMPS& lammps_;
  Script& script_;
  std::string id_;
  bool in_run_ = false;
  long long later_ = 0;
  std::map<std::pair<int, std::size_t>, std::vector<bool>> region_faces_;  // of patches by region: side, condition
};

}  // namespace twogrid
