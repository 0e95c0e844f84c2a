// Drag laws: pure functions of the void fraction and the Reynolds number, in one table.
//
// Every law is brought to one form (SI units, eps void fraction, eps_s = 1 - eps, u interstitial fluid velocity):
//   F(eps, Re, y) = drag force / (3 pi mu d eps |u - v|)        dimensionless
//   b_p  = 3 pi mu d eps F                                       kg/s, force = b_p (u - v)
//   beta = 18 mu eps eps_s F / d^2                               kg/(m3 s), spheres of one diameter
//   Re   = eps rho_f |u - v| d / mu                              superficial slip, diameter of the particle itself
//   y    = d / <d>, <d> = sum N_k d_k^3 / sum N_k d_k^2 (Sauter mean); laws for one diameter don't look at it
//
// "Drag force" is the force of formulation A: what is left of the fluid's force when -V_p grad p is taken out. In a
// steady uniform bed -eps grad p V = sum of drag, and the total force of the fluid on a particle (drag - V_p grad p) is
// drag/eps. A source that gives the total force, or a pressure drop, is therefore multiplied by eps. Formulation B uses
// b_p / eps; the caller divides.
//
// All laws are finite and positive for eps in [0.2, 1] and Re in [0, 1e5] (Ergun vanishes at eps = 1, Re = 0); at eps =
// 1 and at Re = 0 they take their analytic limits. Beyond the range its authors fitted, a law is extrapolated as it
// stands. Nothing here is collective, allocates (drag_law_names apart) or keeps state.
#pragma once

#include <string>

namespace twogrid {

constexpr int kDragBatch = 8;

struct DragLaw {
  const char* name;                              ///< the word after `fix_modify ID drag`
  double (*F)(double eps, double Re, double y);  ///< see above
  /// F of n particles at once, n a multiple of kDragBatch: to some units in the last place the same, and the same
  /// whatever the place of a particle in the arrays.
  void (*F_of)(int n, const double* eps, const double* Re, const double* y, double* F);
  const char* reference;      ///< author, year, equation
  bool for_mixtures = false;  ///< looks at y; the other laws know one size
};

/// The law called `name`, or nullptr if there is none. Lives as long as the program.
const DragLaw* find_drag_law(const std::string& name);

/// All names, separated by blanks, for error messages.
std::string drag_law_names();
/// Those of laws for mixtures.
std::string mixture_law_names();

/// b_p (kg/s) of a particle of diameter d (m) at slip = |u - v| (m/s) in a fluid of rho_f (kg/m3) and mu (Pa s).
inline double drag_coefficient(const DragLaw& law, double eps, double d, double slip, double rho_f, double mu,
                               double y) {
  constexpr double kThreePi = 9.42477796076937971539;
  return kThreePi * mu * d * eps * law.F(eps, eps * rho_f * slip * d / mu, y);
}

}  // namespace twogrid
