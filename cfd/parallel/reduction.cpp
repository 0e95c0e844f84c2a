#include "cfd/parallel/reduction.h"

#include <cmath>
#include <stdexcept>

namespace twogrid {

namespace {

/// One element of MPI's reductions, so that they don't cut it in pieces.
struct Values {
  double largest[Reduction::kLargest];
  double sum[Reduction::kSums];
};

void combine(void* from, void* to, int* count, MPI_Datatype*) {
  const Values* a = static_cast<const Values*>(from);
  Values* b = static_cast<Values*>(to);
  for (int q = 0; q < *count; ++q) {
    for (int i = 0; i < Reduction::kLargest; ++i)
      if (a[q].largest[i] > b[q].largest[i] || std::isnan(a[q].largest[i])) b[q].largest[i] = a[q].largest[i];
    for (int i = 0; i < Reduction::kSums; ++i) b[q].sum[i] += a[q].sum[i];
  }
}

struct Handles {
  MPI_Datatype type;
  MPI_Op op;
  Handles() {
    MPI_Type_contiguous(sizeof(Values) / sizeof(double), MPI_DOUBLE, &type);
    MPI_Type_commit(&type);
    MPI_Op_create(&combine, 1, &op);
  }
};

}  // namespace

void Reduction::over_ranks(MPI_Comm comm, std::initializer_list<double*> largest, std::initializer_list<double*> sums) {
  if (largest.size() > kLargest || sums.size() > kSums) throw std::logic_error("too many values in one reduction");
  static const Handles mpi;  // MPI frees them when it ends
  Values v = {};
  double* at = v.largest;
  for (const double* a : largest) *at++ = *a;
  at = v.sum;
  for (const double* a : sums) *at++ = *a;
  MPI_Allreduce(MPI_IN_PLACE, &v, 1, mpi.type, mpi.op, comm);
  at = v.largest;
  for (double* a : largest) *a = *at++;
  at = v.sum;
  for (double* a : sums) *a = *at++;
}

}  // namespace twogrid
