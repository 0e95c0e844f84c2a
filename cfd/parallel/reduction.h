// Largest values and sums over all ranks, together in one collective.
#pragma once

#include <mpi.h>

#include <initializer_list>

namespace twogrid {

class Reduction {
 public:
  static constexpr int kLargest = 8, kSums = 12;  ///< at most

  /// Values by address, replaced by those of all ranks; the same bits on all of them. Collective. A largest value that
  /// is not a number anywhere is not a number afterwards.
  static void over_ranks(MPI_Comm comm, std::initializer_list<double*> largest, std::initializer_list<double*> sums);
};

}  // namespace twogrid
