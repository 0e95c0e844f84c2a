#include "liggghts_fixes/liggghts/mesh_order.h"

#include <comm.h>
#include <fix_mesh_surface.h>
#include <fix_move_mesh.h>
#include <lammps.h>
#include <modify.h>
#include <update.h>

#include <algorithm>
#include <cstddef>
#include <list>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/private_member.h"

namespace {

using Mesh = LAMMPS_NS::MultiNodeMeshParallel<3>;
using Nodes = LAMMPS_NS::MultiVectorContainer<double, 3, 3>;
using Centres = LAMMPS_NS::VectorContainer<double, 3>;
using Push = int(int, double*, int, bool, bool, bool);
using Pop = int(double*, int, bool, bool, bool);
using Size = int(int, std::list<std::string>*, bool, bool, bool);
using Delete = void(int);
using Clear = void();
PRIVATE_MEMBER(SharedOut, Mesh, bool, doParallellization_);
PRIVATE_MEMBER(Owned, Mesh, int, nLocal_);
PRIVATE_MEMBER(PushElement, Mesh, Push, pushElemToBuffer);
PRIVATE_MEMBER(PopElement, Mesh, Pop, popElemFromBuffer);
PRIVATE_MEMBER(ElementSize, Mesh, Size, elemBufSize);
PRIVATE_MEMBER(DeleteElement, Mesh, Delete, deleteElement);
PRIVATE_MEMBER(ClearGhosts, Mesh, Clear, clearGhosts);
PRIVATE_MEMBER(NodesOf, LAMMPS_NS::MultiNodeMesh<3>, Nodes, node_);
PRIVATE_MEMBER(CentresOf, LAMMPS_NS::MultiNodeMesh<3>, Centres, center_);

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// Own triangles by their IDs, as if each were sent to this rank again; ghosts are dropped. Nothing where they lie so.
void sort_own(Mesh& mesh) {
  std::vector<int> order(mesh.sizeLocal());
  std::iota(order.begin(), order.end(), 0);
  const auto by_id = [&](int a, int b) { return mesh.id(a) < mesh.id(b); };
  if (std::is_sorted(order.begin(), order.end(), by_id)) return;
  std::sort(order.begin(), order.end(), by_id);
  (mesh.*member(ClearGhosts()))();
  const int most = (mesh.*member(ElementSize()))(OPERATION_COMM_EXCHANGE, nullptr, false, false, false);
  std::vector<double> values(order.size() * std::size_t(most));
  double* at = values.data();
  for (int i : order) at += (mesh.*member(PushElement()))(i, at, OPERATION_COMM_EXCHANGE, false, false, false);
  for (int i = mesh.sizeLocal(); i-- > 0;) (mesh.*member(DeleteElement()))(i);
  at = values.data();
  for (std::size_t i = 0; i < order.size(); ++i) {
    at += (mesh.*member(PopElement()))(at, OPERATION_COMM_EXCHANGE, false, false, false);
    ++(mesh.*member(Owned()));
  }
}

}  // namespace

void order_meshes(LAMMPS& lammps) {
  Modify& modify = *lammps.modify;
  if (lammps.comm->nprocs == 1) return;
  for (int f = 0; f < modify.nfix; ++f) {
    auto* const fix = dynamic_cast<FixMeshSurface*>(modify.fix[f]);
    if (!fix) continue;
    Mesh& mesh = *fix->triMesh();
    if (!(mesh.*member(SharedOut()))) continue;
    // Before its first run every rank has all triangles: in the order of the file, or in that of the ranks that wrote the
    // restart file. Edges and corners are found in this order.
    if (!mesh.isParallel()) sort_own(mesh);
    fix->FixMesh::setup_pre_force(0);
    sort_own(mesh);
  }
}

void find_mesh_velocities(LAMMPS& lammps) {
  Modify& modify = *lammps.modify;
  for (int f = 0; f < modify.nfix; ++f) {
    auto* const mover = dynamic_cast<FixMoveMesh*>(modify.fix[f]);
    auto* const fix = mover ? dynamic_cast<FixMeshSurface*>(mover->fixMesh()) : nullptr;
    if (!fix) continue;
    TriMesh& mesh = *fix->triMesh();
    Nodes& nodes = mesh.*member(NodesOf());
    Centres& centres = mesh.*member(CentresOf());
    const int n = mesh.sizeLocal() + mesh.sizeGhost();
    std::vector<double> kept;
    const auto each = [&](auto&& f) {
      for (int i = 0; i < n; ++i)
        for (int d = 0; d < 3; ++d) {
          f(centres(i)[d]);
          for (int j = 0; j < 3; ++j) f(nodes(i)[j][d]);
        }
    };
    each([&](double& x) { kept.push_back(x); });
    mover->setup(0);  // makes the column of velocities where there is none
    const double dt = std::exchange(lammps.update->dt, 0.0);
    mover->initial_integrate(0);
    lammps.update->dt = dt;
    // A turn by nothing about a point is round-off.
    const double* x = kept.data();
    each([&](double& now) { now = *x++; });
  }
}

}  // namespace twogrid
