#include "end_run.h"

#include <lammps.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace twogrid {
namespace {

bool all_arrive(MPI_Comm comm, double seconds) {
  MPI_Request request;
  MPI_Ibarrier(comm, &request);
  const double limit = MPI_Wtime() + seconds;
  for (;;) {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done) return true;
    if (MPI_Wtime() > limit) return false;
    usleep(1000);
  }
}

void say(LAMMPS_NS::LAMMPS* lammps, const std::string& text) {
  FILE* screen = lammps && lammps->screen ? lammps->screen : stdout;
  std::fprintf(screen, "%s\n", text.c_str());
  std::fflush(screen);
  if (lammps && lammps->logfile) {
    std::fprintf(lammps->logfile, "%s\n", text.c_str());
    std::fflush(lammps->logfile);
  }
}

}  // namespace

void end_with_error(LAMMPS_NS::LAMMPS* lammps, MPI_Comm comm, const std::string& sentence) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (all_arrive(comm, 2.0)) {
    if (rank == 0) say(lammps, "ERROR: " + sentence);
    MPI_Finalize();
    std::exit(EXIT_FAILURE);
  }
  say(lammps, "ERROR on rank " + std::to_string(rank) + ": " + sentence);
  MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
  std::_Exit(EXIT_FAILURE);
}

}  // namespace twogrid
