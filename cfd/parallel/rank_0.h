// What one rank knows or does, and all must hear.
#pragma once

#include <mpi.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "cfd/parallel/ranks.h"

namespace twogrid {

/// Of that rank, on all. Collective.
inline std::string from_rank(MPI_Comm comm, int rank, std::string s) {
  unsigned long n = s.size();
  MPI_Bcast(&n, 1, MPI_UNSIGNED_LONG, rank, comm);
  s.resize(n);
  MPI_Bcast(s.data(), int(n), MPI_CHAR, rank, comm);
  return s;
}

/// Runs f on rank 0; throws what it throws on all ranks, as std::runtime_error. Collective.
template <class F>
void on_rank_0(MPI_Comm comm, F&& f) {
  std::string why;
  if (rank_of(comm) == 0) {
    try {
      f();
    } catch (const std::exception& e) {
      why = e.what();
    }
  }
  why = from_rank(comm, 0, std::move(why));
  if (!why.empty()) throw std::runtime_error(why);
}

}  // namespace twogrid
