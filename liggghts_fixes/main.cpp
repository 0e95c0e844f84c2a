// twogrid: LIGGGHTS, with fix twogrid. Same command line and scripts as LIGGGHTS, plus PETSc's options.
#include <lammps.h>
#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/report/status.h"
#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/run/end_run.h"
#include "liggghts_fixes/run/old_files.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/run/session.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/run/still_files.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/style_registry.h"

namespace twogrid {
namespace {

/// Nothing is written: no log, no status, and no screen of the user's; files of the script are still.
void plan_only(CommandLine& line) {
  keep_files_still();
  line.log = "none";
  std::vector<std::string> kept{line.liggghts[0]};
  for (std::size_t i = 1; i < line.liggghts.size(); ++i) {
    const std::string& w = line.liggghts[i];
    if (w == "-log" || w == "-l" || w == "-screen" || w == "-sc")
      ++i;
    else
      kept.push_back(w);
  }
  kept.insert(kept.end(), {"-log", "none"});
  line.liggghts = kept;
}

}  // namespace
}  // namespace twogrid

int main(int argc, char** argv) {
  // Whole lines are out at once, also where the output is a file or a pipe and a run doesn't end well.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  twogrid::install_signal_handlers();  // from the first moment on
  MPI_Init(&argc, &argv);
  MPI_Comm errors;
  MPI_Comm_dup(MPI_COMM_WORLD, &errors);

  LAMMPS_NS::LAMMPS* lammps = nullptr;
  int status = 0;
  try {
    twogrid::CommandLine line = twogrid::split_command_line({argv, argv + argc});
    if (line.version || line.keywords) {
      int rank = 0;
      MPI_Comm_rank(MPI_COMM_WORLD, &rank);
      if (rank == 0 && line.keywords) std::fputs(twogrid::keyword_page().c_str(), stdout);
      if (rank == 0 && line.version)
        std::printf("twogrid %s (%s), PETSc %s\n", TWOGRID_VERSION, TWOGRID_COMMIT, twogrid::petsc_version().c_str());
      MPI_Finalize();
      return 0;
    }
    twogrid::start_petsc(line.petsc);
    twogrid::install_signal_handlers();  // PETSc has put the default ones back
    if (line.plan > 0) twogrid::plan_only(line);
    twogrid::open_status(line.log, "twogrid " TWOGRID_VERSION " (" TWOGRID_COMMIT ")", errors);
    twogrid::Checkpoint from = twogrid::checkpoint_wanted(MPI_COMM_WORLD, line);
    twogrid::set_restarting(!line.restart.empty());
    if (!from.path.empty()) {
      int rank = 0;
      MPI_Comm_rank(MPI_COMM_WORLD, &rank);
      if (rank == 0 && line.plan == 0) twogrid::keep_file(line.log);
      MPI_Barrier(MPI_COMM_WORLD);
    }
    std::vector<char*> words;
    for (std::string& w : line.liggghts) words.push_back(w.data());
    lammps = new LAMMPS_NS::LAMMPS(int(words.size()), words.data(), MPI_COMM_WORLD);
    twogrid::keep_sentences(lammps);
    if (line.plan > 0) twogrid::quieten_screen();
    twogrid::register_styles(*lammps, line.particles);
    twogrid::Session session(*lammps, line, std::move(from));
    twogrid::handle_runs([&](const std::string& name, std::vector<std::string> w) {
      w.insert(w.begin(), name);
      session.run_command(w);
    });
    const int signal = session.run();
    twogrid::handle_runs({});
    status = signal == 0 ? 0 : 128 + signal;
    signal == 0 ? twogrid::Status::of_process().finish() : twogrid::Status::of_process().end_by_signal(signal);
    twogrid::keep_sentences(nullptr);
    delete lammps;
  } catch (const twogrid::EndedBySignal& e) {
    twogrid::end_with_error(lammps, errors, e.what(), 128 + e.number);
  } catch (const std::exception& e) {
    twogrid::end_with_error(lammps, errors, e.what(), EXIT_FAILURE);
  }
  MPI_Comm_free(&errors);
  MPI_Finalize();
  return status;
}
