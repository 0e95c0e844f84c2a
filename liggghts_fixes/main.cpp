// twogrid: LIGGGHTS, with fix twogrid. Same command line and scripts as LIGGGHTS, plus PETSc's options.
#include <input.h>
#include <lammps.h>
#include <mpi.h>
#include <signal_handling.h>
#include <update.h>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/run/end_run.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/run/signals.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/style_registry.h"

namespace {

/// Runs the script. Returns the signal that ended it, or 0.
int run_script(LAMMPS_NS::LAMMPS& lammps) {
  lammps.input->file();
  if (!LAMMPS_NS::SignalHandler::request_quit) return 0;
  LAMMPS_NS::SignalHandler::request_quit = false;  // else no command is taken any more
  const std::string file = "restart.signal." + std::to_string(lammps.update->ntimestep);
  lammps.input->one(("write_restart " + file).c_str());
  if (lammps.screen) std::fprintf(lammps.screen, "twogrid: ended by a signal; the particles are in %s\n", file.c_str());
  if (lammps.logfile)
    std::fprintf(lammps.logfile, "twogrid: ended by a signal; the particles are in %s\n", file.c_str());
  const int seen = twogrid::signal_seen();
  int number = 0;
  MPI_Allreduce(&seen, &number, 1, MPI_INT, MPI_MAX, lammps.world);
  return number;
}

}  // namespace

int main(int argc, char** argv) {
  // Whole lines are out at once, also where the output is a file or a pipe and a run doesn't end well.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
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
    std::vector<char*> words;
    for (std::string& w : line.liggghts) words.push_back(w.data());
    lammps = new LAMMPS_NS::LAMMPS(int(words.size()), words.data(), MPI_COMM_WORLD);
    twogrid::keep_sentences(lammps);
    twogrid::register_styles(*lammps, line.particles);
    const int signal = run_script(*lammps);
    status = signal == 0 ? 0 : 128 + signal;
    twogrid::keep_sentences(nullptr);
    delete lammps;
  } catch (const std::exception& e) {
    twogrid::end_with_error(lammps, errors, e.what());
  }
  MPI_Comm_free(&errors);
  MPI_Finalize();
  return status;
}
