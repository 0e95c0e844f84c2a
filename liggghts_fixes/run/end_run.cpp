#include "liggghts_fixes/run/end_run.h"

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

/// What was last shown on the screen of LIGGGHTS' rank 0.
std::string shown;
constexpr std::size_t kShown = 4096;

ssize_t show(void*, const char* text, size_t n) {
  const size_t written = std::fwrite(text, 1, n, stdout);
  std::fflush(stdout);
  shown.append(text, written);
  if (shown.size() > 2 * kShown) shown.erase(0, shown.size() - kShown);
  return ssize_t(written);
}

LAMMPS_NS::LAMMPS* watched = nullptr;

}  // namespace

void keep_sentences(LAMMPS_NS::LAMMPS* lammps) {
  watched = lammps;
  if (!lammps || lammps->screen != stdout) return;
  const cookie_io_functions_t functions = {nullptr, show, nullptr, nullptr};
  FILE* const screen = fopencookie(nullptr, "w", functions);
  if (!screen) return;
  std::setvbuf(screen, nullptr, _IOLBF, BUFSIZ);
  lammps->screen = screen;
}

void write_last_sentence() {
  if (watched && watched->screen) std::fflush(watched->screen);
  if (watched && watched->logfile) {
    const std::size_t error = shown.rfind("ERROR");
    std::fputs(error == std::string::npos ? "ERROR: told on the screen\n" : shown.c_str() + error, watched->logfile);
  }
  std::fflush(nullptr);
}

void end_with_error(LAMMPS_NS::LAMMPS* lammps, MPI_Comm comm, const std::string& sentence, int code) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (all_arrive(comm, 2.0)) {
    if (rank == 0) say(lammps, "ERROR: " + sentence);
    MPI_Finalize();
    std::exit(code);
  }
  say(lammps, "ERROR on rank " + std::to_string(rank) + ": " + sentence);
  std::fflush(nullptr);
  PMPI_Abort(MPI_COMM_WORLD, code);
  std::_Exit(code);
}

}  // namespace twogrid

/// In place of MPI's own (the standard lets a program do so; PMPI_Abort is the same): LIGGGHTS' errors of a single rank
/// end here.
extern "C" int MPI_Abort(MPI_Comm comm, int code) {
  twogrid::write_last_sentence();
  return PMPI_Abort(comm, code);
}
