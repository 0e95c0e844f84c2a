#include "cfd/bodies/sentences.h"

#include <sstream>
#include <stdexcept>

#include "cfd/parallel/rank_0.h"

namespace twogrid {

std::string words(const Vec3& x) {
  std::ostringstream s;
  s << "(" << x[0] << " " << x[1] << " " << x[2] << ")";
  return s.str();
}

void refuse_together(MPI_Comm comm, const std::string& sentence) {
  const int none = ranks_of(comm);
  int first = sentence.empty() ? none : rank_of(comm);
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first < none) throw std::invalid_argument(from_rank(comm, first, sentence));
}

}  // namespace twogrid
