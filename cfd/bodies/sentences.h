// Words of the bodies' sentences.
#pragma once

#include <mpi.h>

#include <string>

#include "cfd/grid/box.h"

namespace twogrid {

std::string words(const Vec3& x);
/// Throws the sentence that the lowest rank has, as std::invalid_argument on all; nothing where none has one. Collective.
void refuse_together(MPI_Comm comm, const std::string& sentence);

}  // namespace twogrid
