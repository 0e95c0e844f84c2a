// PETSc inside a program that LIGGGHTS may end at any moment by MPI_Finalize and exit.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace twogrid {

/// Initialises PETSc, after MPI_Init, with its own words of the command line (the first is the program's name). PETSc
/// is finalised by a callback that MPI_Finalize runs first, whoever calls it. PETSc's errors become one line on
/// standard error at their origin and a return code; its signal handler is taken out. Collective. Throws
/// std::runtime_error.
void start_petsc(const std::vector<std::string>& words);
/// -fluid_bricks PX,PY,PZ: bricks of the fluid's cells, for `ranks` ranks; empty: not given. Throws
/// std::invalid_argument.
std::optional<std::array<int, 3>> fluid_bricks_option(int ranks);
/// -balance on|off: whether the ranks' parts of the box follow the particles. On if not given.
bool balance_option();
/// -skin best|script: whether neighbour lists whose skin is far from the best get another. The script's if not given.
bool best_skin_option();
/// Options of the command line that nothing has asked for: misspelt, most likely.
class UnusedOptions {
 public:
  /// A sentence for each that begins with `beginning` (with its dash), not with `but`, and that none told before.
  std::vector<std::string> sentences(const std::string& beginning, const std::string& but);

 private:
  std::vector<std::string> told_;
};
/// Cells that PETSc's integers can number.
double most_cells();
/// "3.18.1"
std::string petsc_version();

}  // namespace twogrid
