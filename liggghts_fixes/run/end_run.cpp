#include "liggghts_fixes/run/end_run.h"

#include <lammps.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "liggghts_fixes/report/status.h"
#include "liggghts_fixes/run/still_files.h"

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

bool is_quiet = false;

/// The lines of errors and warnings.
size_t show_worst(const char* text, size_t n) {
  static std::string line;
  for (size_t i = 0; i < n; ++i) {
    line += text[i];
    if (text[i] != '\n') continue;
    if (line.rfind("ERROR", 0) == 0 || line.rfind("WARNING", 0) == 0) std::fputs(line.c_str(), stdout);
    line.clear();
  }
  return n;
}

ssize_t show(void*, const char* text, size_t n) {
  const size_t written = is_quiet ? show_worst(text, n) : std::fwrite(text, 1, n, stdout);
  std::fflush(stdout);
  shown.append(text, written);
  if (shown.size() > 2 * kShown) shown.erase(0, shown.size() - kShown);
  return ssize_t(written);
}

LAMMPS_NS::LAMMPS* watched = nullptr;

/// LIGGGHTS' last error as the screen has it, from its ERROR on.
std::string last_error() {
  const std::size_t error = shown.rfind("ERROR");
  return error == std::string::npos ? "ERROR: told on the screen\n" : shown.substr(error);
}

/// The line of it, without the word.
std::string last_sentence() {
  const std::string error = last_error(), line = error.substr(0, error.find('\n'));
  return line.rfind("ERROR: ", 0) == 0 ? line.substr(7) : line;
}

/// Why a file could not be opened and what mends it, where that was the error; else nothing.
std::string why_unopened() {
  const UnopenedFile& file = unopened_file();
  if (file.path.empty() || last_error().find("annot open") == std::string::npos) return "";
  const std::size_t slash = file.path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : file.path.substr(0, std::max<std::size_t>(slash, 1));
  if (file.error == ENOENT)
    return "twogrid: there is no folder " + folder + " for the file " + file.path +
           "; make it before the run, or in the script by: shell mkdir " + folder;
  return "twogrid: the file " + file.path + " could not be opened: " + std::strerror(file.error);
}

/// LIGGGHTS' errors of all ranks, and its command quit (with code 1, too, but without a word), end here.
void tell_status(int code, void*) {
  if (code == 0 || (!shown.empty() && shown.find("ERROR") == std::string::npos))
    Status::of_process().finish();
  else
    Status::of_process().fail(last_sentence());
}

/// An error of all ranks begins to end MPI, where they still wait for each other: once a rank has left, the launcher may
/// kill the others before their exit.
extern "C" int tell_error(MPI_Comm, int, void*, void*) {
  if (shown.find("ERROR") != std::string::npos) Status::of_process().fail(last_sentence());
  return MPI_SUCCESS;
}

void tell_at_the_end() {
  int key = MPI_KEYVAL_INVALID;
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, tell_error, &key, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
}

}  // namespace

void keep_sentences(LAMMPS_NS::LAMMPS* lammps) {
  watched = lammps;
  static const int told = (tell_at_the_end(), on_exit(tell_status, nullptr));
  (void)told;
  if (!lammps || lammps->screen != stdout) return;
  const cookie_io_functions_t functions = {nullptr, show, nullptr, nullptr};
  FILE* const screen = fopencookie(nullptr, "w", functions);
  if (!screen) return;
  std::setvbuf(screen, nullptr, _IOLBF, BUFSIZ);
  lammps->screen = screen;
}

void quieten_screen() {
  is_quiet = true;
}

void write_last_sentence() {
  if (watched && watched->screen) std::fflush(watched->screen);
  if (watched && watched->logfile) std::fputs(last_error().c_str(), watched->logfile);
  if (const std::string why = why_unopened(); !why.empty()) say(watched, why);
  Status::of_process().fail_alone(last_sentence());
  std::fflush(nullptr);
  forget_still_files();
}

void end_with_error(LAMMPS_NS::LAMMPS* lammps, MPI_Comm comm, const std::string& sentence, int code) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (all_arrive(comm, 2.0)) {
    if (rank == 0) say(lammps, "ERROR: " + sentence);
    if (code > 128)
      Status::of_process().end_by_signal(code - 128, sentence);
    else
      Status::of_process().fail(sentence);
    MPI_Finalize();
    std::exit(code);
  }
  say(lammps, "ERROR on rank " + std::to_string(rank) + ": " + sentence);
  Status::of_process().fail_alone(sentence);
  std::fflush(nullptr);
  forget_still_files();
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
