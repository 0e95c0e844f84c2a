// Adds this project's styles to a LIGGGHTS that was built without them.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Registers fix twogrid, in this LIGGGHTS and in every one that the script's `clear` makes after it, and commands
/// `run` and `run_time` that first move fix twogrid behind all fixes that add forces: the drag rescales the total
/// force, so that it has to come last.
///
/// Puts our own code, of the same results to the last bit, in the place of LIGGGHTS' for contacts of particles
/// (pair_style gran model hooke/stiffness tangential history), plane walls of that law, nve/sphere, gravity and
/// neighbour lists. kernel: "auto", "plain", "AVX2", "AVX-512", or "stock", which leaves LIGGGHTS as it is.
/// Throws std::invalid_argument for a kernel that the processor can't run. Call once, before the script is read. Not
/// collective.
void register_styles(LAMMPS_NS::LAMMPS& lammps, const std::string& kernel);

/// What takes a command `run` or `run_time` (name, words) from the script from now on; empty: stock_run().
using RunHandler = std::function<void(const std::string& name, const std::vector<std::string>& words)>;
void handle_runs(RunHandler handler);
/// LIGGGHTS' own command of that name, with the fixes in our order. Collective.
void stock_run(LAMMPS_NS::LAMMPS& lammps, const std::string& name, const std::vector<std::string>& words);
/// LIGGGHTS' own write_restart. Collective.
void stock_write_restart(LAMMPS_NS::LAMMPS& lammps, const std::string& path);

}  // namespace twogrid
