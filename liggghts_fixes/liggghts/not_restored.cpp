#include "liggghts_fixes/liggghts/not_restored.h"

#include <fix.h>
#include <fix_move_mesh.h>
#include <input.h>
#include <lammps.h>
#include <modify.h>
#include <variable.h>

#include <cstring>

#include "liggghts_fixes/private_member.h"

namespace {

PRIVATE_MEMBER(Formulas, LAMMPS_NS::Variable, char***, data);
PRIVATE_MEMBER(Count, LAMMPS_NS::Variable, int, nvar);
PRIVATE_MEMBER(Names, LAMMPS_NS::Variable, char**, names);

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// The fix move/mesh before this one that moves the same mesh, and with it this one's axis; empty: none.
std::string earlier_mover(const Modify& modify, int i) {
  auto* const mover = dynamic_cast<FixMoveMesh*>(modify.fix[i]);
  for (int e = 0; mover && e < i; ++e) {
    auto* const other = dynamic_cast<FixMoveMesh*>(modify.fix[e]);
    if (other && other->fixMesh() == mover->fixMesh()) return other->id;
  }
  return "";
}

}  // namespace

std::vector<std::string> not_restored(LAMMPS& lammps) {
  std::vector<std::string> said;
  const Modify& modify = *lammps.modify;
  for (int i = 0; i < modify.nfix; ++i) {
    const std::string id = modify.fix[i]->id, style = modify.fix[i]->style;
    const std::string fix = "fix " + id + " " + style + ": ";
    if (style.rfind("ave/", 0) == 0)
      said.push_back(fix + "a mean that has begun begins anew at a restart");
    else if (const std::string carrier = earlier_mover(modify, i); !carrier.empty())
      said.push_back(fix + "its axis is that of the script again at a restart, not where fix " + carrier +
                     " has taken it");
    else if (style.rfind("massflow/mesh/sieve", 0) == 0)
      said.push_back(fix + "its random numbers begin anew at a restart");
  }
  const Variable& variable = *lammps.input->variable;
  for (int i = 0; i < variable.*member(Count()); ++i) {
    const char* formula = (variable.*member(Formulas()))[i] ? (variable.*member(Formulas()))[i][0] : nullptr;
    for (const char* word : {"random(", "normal("})
      if (formula && std::strstr(formula, word))
        said.push_back("variable " + std::string((variable.*member(Names()))[i]) +
                       ": its random numbers begin anew at a restart");
  }
  return said;
}

}  // namespace twogrid
