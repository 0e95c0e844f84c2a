#include "liggghts_fixes/bodies/mesh_triangles.h"

#include <fix_mesh_surface.h>

#include <algorithm>

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

}  // namespace twogrid
