// The triangles of fix mesh/surface, of which LIGGGHTS keeps a part on each rank.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "cfd/bodies/triangle_set.h"
#include "cfd/parallel/ranks.h"

namespace LAMMPS_NS {
class FixMeshSurface;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace twogrid {

/// Of all ranks, on all, in their order. T: of doubles. Collective.
template <class T>
std::vector<T> gathered(const std::vector<T>& own, MPI_Comm comm) {
  constexpr int kNumbers = sizeof(T) / sizeof(double);
  const int ranks = ranks_of(comm), mine = int(own.size()) * kNumbers;
  std::vector<int> counts(ranks), places(ranks);
  MPI_Allgather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  int total = 0;
  for (int r = 0; r < ranks; ++r) places[r] = total, total += counts[r];
  std::vector<T> all(total / kNumbers);
  MPI_Allgatherv(own.data(), mine, MPI_DOUBLE, all.data(), counts.data(), places.data(), MPI_DOUBLE, comm);
  return all;
}

/// All of them on all ranks, in an order that depends on nothing but their corners. Collective.
std::vector<Triangle> mesh_triangles(LAMMPS_NS::FixMeshSurface& mesh, MPI_Comm comm);

}  // namespace twogrid
