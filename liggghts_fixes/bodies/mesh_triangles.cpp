#include "liggghts_fixes/bodies/mesh_triangles.h"

#include <fix_mesh_surface.h>
#include <fix_move_mesh.h>
#include <lammps.h>
#include <modify.h>

#include <algorithm>
#include <cstring>

namespace twogrid {

using namespace LAMMPS_NS;

std::vector<Triangle> mesh_triangles(FixMeshSurface& fix, MPI_Comm comm) {
  TriMesh& mesh = *fix.triMesh();
  std::vector<Triangle> own(mesh.sizeLocal());
  for (std::size_t i = 0; i < own.size(); ++i)
    for (int j = 0; j < 3; ++j) mesh.node(int(i), j, own[i][j].data());
  // Before its first run every rank has the whole of it.
  std::vector<Triangle> all = mesh.isParallel() ? gathered(own, comm) : std::move(own);
  std::sort(all.begin(), all.end());
  return all;
}

bool mesh_moves(LAMMPS& lammps, FixMeshSurface& mesh, std::string* how) {
  Modify& modify = *lammps.modify;
  for (int f = 0; f < modify.nfix; ++f)
    if (auto* mover = dynamic_cast<FixMoveMesh*>(modify.fix[f]))
      if (mover->fixMeshCompare(&mesh)) {
        *how = "that fix " + std::string(mover->id) + " " + mover->style + " moves";
        return true;
      }
  const bool by_itself = std::strstr(mesh.style, "6dof") || std::strstr(mesh.style, "servo");
  if (mesh.triMesh()->isMoving() || mesh.triMesh()->isDeforming() || by_itself) {
    *how = "that moves or deforms (" + std::string(mesh.style) + ")";
    return true;
  }
  return false;
}

}  // namespace twogrid
