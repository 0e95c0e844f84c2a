// The particles as the coupling sees them: arrays owned by someone else (LIGGGHTS, or a test).
#pragma once

#include "cfd/grid/box.h"

namespace twogrid {

/// Columns of the state that the coupling keeps with every particle. It migrates and restarts with the particle; a new
/// particle's state is all zero. The first ten columns are, in this order, what a user sees as the per-atom array f_ID.
/// A row is three cache lines; memory from malloc begins two columns into one, so that what the end of an interval
/// needs, columns 14 to 21, is a line.
enum ParticleColumn {
  kDragForce = 0,      ///< 0-2 drag of the current step (N), where Particles::watched
  kPressureForce = 3,  ///< 3-5 -V_p grad p as read at the last coupling (N); zero in formulation B with one size
  kVoidFraction = 6,   ///< 6 eps that the particle sees
  kFluidVelocity = 7,  ///< 7-9 u read at the last coupling, by the weights of the reaction (m/s)
  kLateForce = 10,     ///< 10-12 stiff steps: force of the half kick after the step's end less that of before (N)
  kSizeRatio = 13,     ///< 13 diameter over the local Sauter mean
  kPosition = 14,      ///< 14-16 x at the last coupling (m); between runs less x, so that a command may change x
  kPathVelocity = 17,  ///< 17-19 path / interval of the last coupling (m/s)
  kResponse = 20,      ///< 20 b_tot: drag coefficient with the share of the pressure force (kg/s)
  kKnown = 21,         ///< 21 not 0: the particle was there at the last coupling
  kRestMass = 22,      ///< 22 mass at the last run's end (kg)
  kRestRadius = 23,    ///< 23 radius then; where particles grow, at the last coupling (m)
  kParticleColumns = 24
};
constexpr int kUserColumns = 10;  ///< the first ones, which a user sees

/// The part of the state that every DEM step needs lies by itself, one particle's beside the next one's: of rows of the
/// above a step would fetch twice the memory.
enum StepColumn {
  kStepVelocity = 0,     ///< 0-2 u that the drag law sees (m/s): u read, but for places where the void fraction jumps
  kDragCoefficient = 3,  ///< 3 b_p; formulation B with one size: b_p/eps (kg/s)
  kImpulse = 4,          ///< 4-6 momentum received from the fluid since the last coupling (kg m/s)
  kDecay = 7,            ///< 7 phi(b_p dt/m) of StepForces; 0: not known, or the step is stiff
  kStepColumns = 8
};

inline double sphere_volume(double radius) {
  constexpr double kFourThirdsPi = 4.18879020478639098462;
  return kFourThirdsPi * radius * radius * radius;
}

/// An acceleration (m/s2) of the particles whose mask has one of the bits of group (~0: of all); several add up.
struct Weight {
  int group;
  Vec3 g;
};

/// A view of this rank's own particles (no ghosts). Positions may lie up to half a skin outside the rank's box.
struct Particles {
  int n = 0;
  double (*x)[3] = nullptr;        ///< m
  double (*v)[3] = nullptr;        ///< m/s
  double (*f)[3] = nullptr;        ///< N
  const double* radius = nullptr;  ///< m
  const double* mass = nullptr;    ///< kg
  const int* tag = nullptr;        ///< identity, may be null
  const int* mask = nullptr;       ///< groups, may be null: all take part
  int group = ~0;                  ///< a particle takes part if mask & group
  /// Groups in which a component of the velocity follows from forces. In the other particles something holds it, or
  /// prescribes it: what the fluid gives them in that direction goes to what holds them.
  int moving[3] = {~0, ~0, ~0};
  int fixed[3] = {0, 0, 0};        ///< groups in which something holds that component all the same
  int frozen[3] = {0, 0, 0};       ///< of these, groups to whose force in that direction nothing may be added
  bool still = false;              ///< no particle of any rank moves or grows
  bool growing = false;            ///< radii change during the run
  bool watched = true;             ///< someone looks at the drag of this step; always so in set-up and where still
  double* const* state = nullptr;  ///< state[i][ParticleColumn]
  double* const* step = nullptr;   ///< step[i][StepColumn]
  double period[3] = {0, 0, 0};    ///< of the box in its periodic directions (m), else 0

  /// Way in direction d since the last coupling (m), across periodic sides too.
  double path(int i, int d) const {
    const double way = x[i][d] - state[i][kPosition + d];
    if (period[d] == 0 || (way < 0.5 * period[d] && way > -0.5 * period[d])) return way;
    return way > 0 ? way - period[d] : way + period[d];
  }

  bool takes_part(int i) const { return !mask || (mask[i] & group); }
  /// false: certainly none is.
  bool some_held() const {
    return mask && ((moving[0] & moving[1] & moving[2]) != ~0 || (fixed[0] | fixed[1] | fixed[2]) != 0);
  }
  /// false: certainly none is held in one direction and free in another.
  bool some_held_in_part() const {
    return mask && (moving[0] != moving[1] || moving[0] != moving[2] || fixed[0] != fixed[1] || fixed[0] != fixed[2]);
  }
  bool is_frozen(int i, int d) const { return mask && (mask[i] & frozen[d]); }
  /// In direction d what holds it takes up its momentum: as if its mass were infinite.
  bool held(int i, int d) const { return mask && (!(mask[i] & moving[d]) || (mask[i] & fixed[d])); }
  /// In all directions.
  bool held(int i) const { return held(i, 0) && held(i, 1) && held(i, 2); }
};

}  // namespace twogrid
