// What a user chooses about the coupling: one line of the methods' table (deposit, onto which grid, prolong, read), the
// drag law, the formulation, the schedule. Plain values, checked before anything is allocated.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cfd/fluid_settings.h"

namespace twogrid {

enum class Deposit { kCentroid, kTrilinear, kExact, kCube };
enum class Prolong { kConstant, kLinear };
enum class Read { kCell, kTrilinear, kFine, kFineTrilinear, kKernel, kCube };
enum class Formulation { kA, kB };
enum class EpsBound { kMove, kClip };
enum class Interpolate { kSmooth, kLinear };  ///< eps(t) between couplings, seen by fluid sub-steps

struct OutputSettings {
  int every = 0;     ///< DEM steps between frames; 0: none
  bool off = false;  ///< `off` was said after a run: no frames until `every` comes again
  std::string file;
  std::vector<std::string> fields;  ///< u p eps ...
  bool particles = true;
  double average_from = -1;   ///< s; negative: no averages
  bool average_auto = false;  ///< from the end of start-up, which is to be found; average_from is 0
  Vec3 up{0, 0, 0};           ///< against gravity, of length 1; 0: there is none
  int average_said = 0;       ///< so often after the first run: means begin anew each time
  double until = 0;           ///< relative standard error of the means at which a run ends; 0: it doesn't
  bool overwrite = false;     ///< a file that is there is replaced
  bool keep_old = false;      ///< it gets another name: a run that was to go on, from which no checkpoint is left
  bool many_legs = false;     ///< a new file each time the run goes on from a checkpoint

  bool writes() const { return !file.empty() && (every > 0 || off || average_from >= 0); }
};

struct Settings {
  std::string id;                                  ///< of the fix, for messages
  std::array<double, 6> domain{0, 0, 0, 0, 0, 0};  ///< of the fluid: xlo xhi ylo yhi zlo zhi (m)
  Int3 fine{0, 0, 0};
  Int3 ratio{1, 1, 1};
  std::array<double, 3> stretch{1, 1, 1};  ///< growth from cell to cell
  std::array<bool, 3> stretch_symmetric{false, false, false};
  int every = 1;                                    ///< DEM steps per coupling
  double accuracy = 0;                              ///< relative error wanted of the steps in time; 0: not watched
  bool cfl_given = false, tolerance_given = false;  ///< by the user, so that `accuracy` leaves them alone
  bool one_way = false;                             ///< particles feel the fluid, the fluid doesn't feel them

  FluidSettings fluid;
  std::string drag = "ergun/wenyu";
  Formulation formulation = Formulation::kB;
  std::string method = "smooth";  ///< the named method (methods.h) that deposit, prolong and read come from
  bool one_grid = false;          ///< it sees the particles on the fine cells: ratio must be 1 1 1
  Deposit deposit = Deposit::kTrilinear;
  Prolong prolong = Prolong::kConstant;
  Read read = Read::kTrilinear;
  double kernel_width = 0;  ///< read kernel: full width (m)
  double cube_edge = 0;     ///< deposit/read cube: edge (m)
  EpsBound bound = EpsBound::kMove;
  double eps_min = 0.3;  ///< smallest void fraction allowed
  Interpolate interpolate = Interpolate::kSmooth;
  Choice hold_flux = Choice::kAuto;  ///< particles see the volume flux held, not the velocity
  OutputSettings output;
};

/// What the coupling can't do whatever the scene: throws std::invalid_argument with a sentence.
void check(const Settings& settings);
/// Width that a particle reads over by its own, of read kernel and cube (m); others: 0, it is the cell's.
double read_width(const Settings& settings);

}  // namespace twogrid
