// What is known of a scene before it runs, and numbers that follow from it. Pure functions.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cfd/bodies/cut_grid.h"
#include "coupling/settings.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

/// A wall of LIGGGHTS, as far as the fluid is concerned.
struct WallFacts {
  enum class Kind { kPlane, kCylinder, kMesh } kind = Kind::kMesh;
  std::string id;                  ///< of the mesh; of the wall's fix, if it is a primitive
  std::string wall;                ///< of the wall's fix
  int axis = -1;                   ///< plane: direction of the normal; cylinder: its axis
  double position = 0;             ///< plane (m)
  double radius = 0;               ///< cylinder (m)
  std::array<double, 6> bounds{};  ///< cylinder and mesh: xlo xhi ylo yhi zlo zhi (m)
  bool solid = false;              ///< the script has made it a body of the fluid
};

/// Neighbour skins in this range cost the same, others up to twice as much (mean diameters; measured:
/// tests/bench/README.md).
constexpr double kLeastSkin = 0.25, kMostSkin = 0.7;

/// Velocities of inlets (along their side's direction) and of bodies that blow, as large as they get in the run to come (m/s).
/// Where a variable hangs on more than the step that isn't known: NaN.
struct InletsAhead {
  std::array<std::vector<double>, 6> side;  ///< of each condition; empty: not looked for
  std::vector<double> body;
};

/// What LIGGGHTS knows about the scene; the same on all ranks.
struct SceneFacts {
  long long particles = 0;                  ///< in the fix's group
  double d_min = 0, d_mean = 0, d_max = 0;  ///< m; of the templates where there are no particles yet; 0: unknown
  /// Of equal spheres that make as rough a void fraction, (sum d^6 / sum d^3)^(1/3) (m); 0: unknown. These and d_most count
  /// what is still to be inserted, too.
  double d_rough = 0, d_most = 0;
  bool sizes_of_templates = false;  ///< there are no particles yet
  double density = 0;               ///< of the particles, kg/m3; 0: unknown
  long long others = 0;             ///< particles outside the fix's group
  Vec3 gravity{0, 0, 0};            ///< mean over the particles, m/s2
  bool weights_differ = false;      ///< fixes gravity for parts of the particles
  bool gravity_varies = false;      ///< there is one that follows a variable: not in the mean
  double dem_dt = 0;                ///< s
  double skin = 0;                  ///< of LIGGGHTS' neighbour lists (m); 0: unknown
  double script_skin = -1;          ///< the script's, where -skin best has taken another (m); else -1
  double contact_time = 0;          ///< s; 0: unknown
  std::string contact_time_from;    ///< how it was found
  std::string contacts;             ///< what evaluates them; empty: no granular pair style
  double equal_kn = 0;              ///< k_n of hooke/stiffness for the same contacts as model hooke, N/m; 0: none
  std::vector<WallFacts> walls;
  InletsAhead ahead;
  std::optional<CutReport> cut;                  ///< bodies in the fluid's grid; none: there are none
  std::optional<OpenNodes::Figures> nodes;       ///< what they make of the particle grid
  std::array<std::vector<double>, 6> open_area;  ///< with bodies: of each condition of each side (m2)
  std::vector<double> drawn_blowing;             ///< of each body's mesh, that blows (m2); 0: unknown
  double chosen_for = 0;  ///< auto chose the particle cells, for particles up to this diameter (m); 0: it didn't
  bool end_told = false;  ///< the choice of grids says what drag a bed lacks where it ends
  bool still = false;     ///< no fix moves particles
  int ranks = 1;
  Int3 bricks{1, 1, 1}, fluid_bricks{1, 1, 1};
  bool sizes_differ() const { return d_max > d_min * (1 + 1e-9); }
};

/// Numbers of the scene; 0 where they can't be known yet.
struct SceneNumbers {
  double h_min = 0;     ///< smallest fine cell (m), directions of one cell left out
  double h_coarse = 0;  ///< smallest particle cell (m), likewise
  double U = 0;         ///< largest superficial velocity that is prescribed, else minimum fluidisation's (m/s)
  double U_bed =
      0;  ///< what all inlets and bodies that blow give over the mean section of the settled bed (m/s); 0: no inlet, or no bed
  double Umf = 0;     ///< Ergun (1952) at eps = 0.4 (m/s)
  double Re = 0;      ///< rho_f U d / mu
  double Stokes = 0;  ///< of collisions, rho_p U d / (9 mu)
  double tau = 0;     ///< response time of particles to the drag, dense: rho_p eps_s / beta (Ergun at eps = 0.4, U), s
  double beta = 0;    ///< drag coefficient of a packed bed (Ergun at eps = 0.4 and U, of the open volume), kg/(m3 s)
  bool U_varies = false;  ///< an inlet or a body that blows follows a variable: U holds its value of now
  bool U_ahead = false;   ///< or the largest of this run
  double v = 0;           ///< of falling particles: terminal, or from the domain's top, whichever is less (m/s)
  double noise = 0;  ///< velocity by which a particle replaces fluid when it changes its particle cell at once (m/s)
  double cfl = 0;    ///< U_max dt_coupling / h_min with interstitial velocity (eps = 1 at inlets)
};

/// Superficial velocity of minimum fluidisation (m/s): Ergun (1952) against the buoyant weight at void fraction eps.
double minimum_fluidisation(double d, double rho_p, double rho_f, double mu, double g, double eps);

/// Particles that lie settled at eps = 0.4 where gravity takes them.
struct SettledBed {
  int along = -1;      ///< gravity's direction; -1: there is no bed to speak of
  double height = 0;   ///< m; what the vessel can hold at most
  double section = 0;  ///< mean over the height, what is open (m2)
  double cells = 0;    ///< particle cells in the height
  double grains = 0;   ///< grains one upon the other in it, of the size that counts for the void fraction
};
SettledBed settled_bed(const Settings& settings, const FineGrid& grid, const SceneFacts& facts);

SceneNumbers scene_numbers(const Settings& settings, const FineGrid& grid, const SceneFacts& facts);

/// DEM steps per coupling when the script says `every auto`: the longest interval within which the fluid crosses cfl fine
/// cells, half a response time of the particles lasts (with 'hold off' 0.3 of them), and fall by CouplingWatch::kTravel of a particle cell; from 1 to 100.
struct AutomaticEvery {
  int steps = 1;
  std::string why;
};
AutomaticEvery automatic_every(const SceneNumbers& numbers, const Settings& settings, double dem_dt);

}  // namespace twogrid
