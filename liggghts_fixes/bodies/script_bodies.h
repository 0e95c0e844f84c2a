// Vessels and bodies that `fix_modify ID solid ...` names: meshes, walls and regions of LIGGGHTS become shapes that the
// fluid's grid is cut by.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cfd/grid/grid.h"
#include "liggghts_fixes/liggghts/script_names.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/script/script.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class ScriptBodies {
 public:
  /// script, names: of the fix; they must live as long.
  ScriptBodies(LAMMPS_NS::LAMMPS& lammps, const Script& script, const ScriptNames& names, int groupbit)
      : lammps_(lammps), script_(script), names_(names), groupbit_(groupbit) {}

  /// The script's bodies, and points that are fluid, into the settings. Throws std::invalid_argument with a sentence for
  /// what there is not, and what can't be a body. Later calls: the fluid's grid is cut for good, so that they must be what
  /// they were; LIGGGHTS may have made them anew. Collective.
  void resolve(FluidSettings& fluid, const FineGrid& grid);
  /// The script's bodies, before the fluid has a grid; `domain`: of any cells. Throws likewise. Collective.
  std::vector<Body> look(const FineGrid& domain) const;
  /// Of the particles that the fluid sees: all or every so many by their number, on all ranks. Collective.
  std::vector<Vec3> some_particles() const;
  /// Which of LIGGGHTS' walls the fluid knows: the bodies themselves, and walls that lie on one. Collective.
  void find_known(std::vector<WallFacts>& walls, const FluidSettings& fluid, const FineGrid& grid) const;
  /// Of each body, the area of its mesh in the domain that blows, as drawn (m2); 0: none, or not a mesh. Collective.
  std::vector<double> drawn_areas(const FluidSettings& fluid, const FineGrid& grid) const;
  /// What a user should know of them beside the scene report, in sentences.
  std::vector<std::string> doubts();

 private:
  Body make(const BodyNames& names, const FineGrid& grid, std::uint64_t* print) const;
  Blow blow_of(const BodyNames& names) const;

  LAMMPS_NS::LAMMPS& lammps_;
  const Script& script_;
  const ScriptNames& names_;
  int groupbit_;                       // of the particles that are in the fluid
  std::vector<std::uint64_t> prints_;  // of each body: what it looked like
};

/// A keyword's beginning in sentences: "solid vessel".
std::string solid_keyword(const BodyNames& names);

}  // namespace twogrid
