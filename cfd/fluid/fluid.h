// The fluid as the coupling sees it. FluidSolver (fluid_solver.h) is the real one; tests use fakes.
#pragma once

#include <string>
#include <vector>

#include "cfd/bodies/body_force.h"
#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"
#include "cfd/grid/void_fraction.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

class WallStress;

/// Values on own faces that are made row by row where they are used, in place of a field.
class FaceRows {
 public:
  virtual ~FaceRows() = default;
  /// Values of the faces normal to d from (i,j,k) to (i+n-1,j,k).
  virtual void row(int d, int i, int j, int k, int n, double* out) const = 0;
};

/// What the particles do to the fluid during one interval. All fields cover own faces (cells) and may be left
/// unallocated (size 0) where a part is absent: it then costs nothing. Momentum balance of the volume V_f of face f:
///   rho_f d(eps u)/dt + ... = - grad p + source - beta u
/// In formulation A the share eps_s of grad p comes back in `source`, as the reaction to the particles' -V_p grad p.
struct Interphase {
  FaceField<FineGrid> source;  ///< force on the fluid per volume (N/m3), constant over the interval
  /// Particles were inserted or deleted: fluid has given or taken their place at the interval's begin, at its own
  /// velocity, and eps.begin is no longer the eps with which the last interval ended.
  bool replaced = false;
  Vec3 particle_flux{0, 0, 0};            ///< mean of eps_s v over the domain (m/s); only for a given flow rate
  const FaceRows* source_rows = nullptr;  ///< in place of source
  const FaceRows* beta_rows = nullptr;    ///< implicit part's coefficient, kg/(m3 s)
  /// Where replaced: by commands between runs. The fluid keeps its flux eps u in place of its velocity, so that nothing
  /// has to be accelerated.
  bool same_flux = false;

  bool reacts() const { return source_rows || source[0].size() > 0; }
  /// Row of source or beta as FaceRows::row() describes it: where it is held, or made in the given memory; null: none.
  const double* source_row(int d, int i, int j, int k, int n, double* made) const {
    if (source[d].size() > 0) return source[d].data() + source[d].index(i, j, k);
    return row_of(source_rows, d, i, j, k, n, made);
  }
  const double* beta_row(int d, int i, int j, int k, int n, double* made) const {
    return row_of(beta_rows, d, i, j, k, n, made);
  }

 private:
  static const double* row_of(const FaceRows* rows, int d, int i, int j, int k, int n, double* made) {
    if (!rows) return nullptr;
    rows->row(d, i, j, k, n, made);
    return made;
  }
};

/// Figures of one call of advance, the same on all ranks.
struct FluidReport {
  int steps = 0;
  double dt = 0;                ///< last fluid step, s
  double cfl = 0;               ///< largest Courant number met
  double divergence_error = 0;  ///< max over cells of |d(eps)/dt + div(eps u)| h/U
  int pressure_iterations = 0;  ///< sum over steps
  double pressure_drop = 0;     ///< mean p of inlet faces minus mean p of outlet faces (Pa), over the interval
  double step_error = -1;       ///< of advance_and_check; negative: not measured
  double inflow = 0, outflow = 0, displaced = 0;  ///< volume in, out, and -integral of d(eps)/dt, last step, m3/s
};

/// Face is solved for, or its normal velocity is prescribed (wall, inlet).
enum class FaceState : unsigned char { kSolved, kFixed };

/// A value a cell that a model keeps: a temperature, a concentration. On the box of the void fraction.
struct ModelField {
  std::string name, unit;
  CellField<FineGrid> values;
};

class Fluid {
 public:
  virtual ~Fluid() = default;

  virtual const FineGrid& grid() const = 0;
  virtual const Layout& layout() const = 0;
  virtual double density() const = 0;
  virtual double viscosity() const = 0;
  /// Width of the halo of all fields returned below, but for means: none in y or z where one cell lies between closed
  /// sides. All have the box of void_fraction().
  static constexpr int kHalo = 2;
  /// State of each own face of direction d and of its halo.
  virtual const Array3<FaceState>& face_state(int d) const = 0;
  /// Open shares of its faces and cells, from the beginning; null: all is open.
  virtual const OpenShares* open_shares() const { return nullptr; }
  /// u (interstitial, m/s) now; halo filled across ranks and periodic sides.
  virtual const FaceField<FineGrid>& velocity() const = 0;
  /// Mean of u over the last interval, as the implicit drag saw it, on all faces of own cells.
  virtual const FaceField<FineGrid>& mean_velocity() const = 0;
  /// Mean of grad p (dynamic pressure, imposed gradient included) over the last interval, on own solved faces. Only
  /// after keep_pressure_gradient().
  virtual const FaceField<FineGrid>& mean_pressure_gradient() const = 0;
  /// From the next interval on the mean of grad p is wanted.
  virtual void keep_pressure_gradient() {}
  virtual const CellField<FineGrid>& pressure() const = 0;
  virtual const CellField<FineGrid>& void_fraction() const = 0;  ///< of the open space
  virtual double time() const = 0;
  /// Forces on the bodies in the grid, means over the last interval, the same on all ranks; empty where there are none.
  virtual const std::vector<BodyForce>& body_forces() const {
    static const std::vector<BodyForce> kNone;
    return kNone;
  }
  /// Place by place on the bodies' surfaces; null unless asked for (FluidSettings::wall_stress).
  virtual WallStress* wall_stress() const { return nullptr; }
  /// Those of models, for output and for what reads them.
  virtual const std::vector<ModelField>& model_fields() const {
    static const std::vector<ModelField> kNone;
    return kNone;
  }
  /// True if flux(), eps u of own faces (m/s), and void_fraction_rate(), d(eps)/dt - q of own cells (1/s), are given as the
  /// discrete continuity of the last step had them; with open shares both of the whole face and cell.
  virtual bool knows_last_step() const { return false; }
  virtual double flux(int, int, int, int) const { return 0; }
  virtual double void_fraction_rate(int, int, int) const { return 0; }

  /// Sets eps of the initial state, and forgets history. Collective.
  virtual void start(const CellField<FineGrid>& eps) = 0;
  /// Advances over the interval. Collective. Throws std::runtime_error with a sentence on all ranks when the solution
  /// is not finite or the pressure solver fails.
  virtual FluidReport advance(double interval, const VoidFractionInTime& eps, const Interphase& exchange) = 0;
  /// The same, to the same result; beside it the interval is taken once more in steps of half the length, and the
  /// report's step_error holds the relative difference of the two: the larger of those in eps u at the end (root mean
  /// square) and in the interval's mean of grad p (its part along grad p itself: the rest is noise that averages out).
  /// About three times the cost of advance. Collective.
  virtual FluidReport advance_and_check(double interval, const VoidFractionInTime& eps, const Interphase& exchange) {
    return advance(interval, eps, exchange);
  }
  /// Courant number above which advance takes smaller steps, from the next call on.
  virtual void limit_courant_number(double) {}
};

}  // namespace twogrid
