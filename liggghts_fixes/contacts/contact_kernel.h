// Contacts of spheres by LIGGGHTS' law hooke/stiffness with tangential history, four at a time:
//   f_n = k_n delta_n - eta_n v_n,   f_t = -k_t delta_t - eta_t v_t,   |f_t| <= mu |f_n|        (Cundall & Strack 1979)
// in LIGGGHTS' own order of operations, so that the results are its own to the last bit. Pure functions, no LIGGGHTS.
//
// Order of a step: pack() copies positions and radii; if particles have moved too far, near_pairs() is made anew;
// touching() picks the pairs in contact; contact_forces() evaluates them, wall_forces() those with a wall; add_weight()
// and kick() are gravity and half a step of velocity Verlet. SI units, local to the rank.
#pragma once

namespace twogrid {

/// Two spheres that may touch before the list is made again. Where LIGGGHTS keeps the pair's history: three components
/// of the tangential spring's length (m), and the flags of the contact models.
struct NearPair {
  int i, j;
  double* spring;
  int* flags;
};

/// Parameters of two types of particles in contact.
struct ContactLaw {
  double kn, kt;  ///< N/m
  double gn, gt;  ///< dashpots, 1/s times the effective mass, or kg/s (absolute)
  double mu;      ///< friction
};

/// LIGGGHTS' arrays; vectors with stride 3. One more double than 3 n_all is readable behind x, v and omega.
struct Spheres {
  int n_local, n_all;  ///< own; own and ghosts
  const double *x, *v, *omega, *radius, *mass;
  const int *type, *mask;
  double *f, *torque;  ///< added to, own particles only
};

struct ContactStep {
  const ContactLaw* law;  ///< [types][types]
  int types;              ///< rows of law
  bool one_law;           ///< law[0] is that of all pairs
  bool absolute;          ///< dashpots in kg/s
  bool push_only;         ///< LIGGGHTS' limitForce: the normal force never pulls
  bool advance;           ///< the springs move (false in set-up)
  int frozen;             ///< bits of particles of infinite mass
  double dt;              ///< s
};

/// A plane wall at rest, normal to an axis.
struct PlaneWall {
  int normal;       ///< 0, 1, 2
  double position;  ///< m
  int type;         ///< of its material
  int group;        ///< bits of the particles that feel it
  double reach;     ///< farther from it a particle's spring stays as it is, m
};

/// How far particles have moved since the list of near pairs was made.
struct Drift {
  double distance;      ///< an upper bound for any of them, m
  bool radius_changed;  ///< of any of them
};

/// Particles sorted by bins; three more are readable behind the last.
struct Binned {
  const double *x, *y, *z, *r;
  const int* index;
};
/// Bins that lie side by side: their number, and how far the first is from a sphere's own bin.
struct BinRun {
  int first, bins;
};
/// Pairs of sphere i with spheres of higher index whose distance is at most (r_i + r_j) factor + skin.
struct PairCutoff {
  double x, y, z, r, factor, skin;
  int i;
};

/// Half a step of motion: v += h f/m, omega += h torque/I, and between them x += dt v if there is a dt.
struct HalfStep {
  double h;            ///< s, half the step
  double dt;           ///< s, 0: x stays
  double mass_factor;  ///< of inertia against v, 1 unless mass is added
  int n, group;        ///< own particles; bits of those that move
  double *x, *v, *omega;
  const double *f, *torque, *radius, *mass;
  const int* mask;
};

struct ContactKernel {
  const char* name;
  /// packed[4 n + ...] = x, y, z, r of n_all spheres; before: the same when the list was made.
  Drift (*pack)(const Spheres& s, double* packed, const double* before);
  /// Of a row of neighbours j of sphere i those nearer than gap (m); returns their number, places in near[].
  int (*near_pairs)(const double* packed, int i, const int* j, int n, double gap, int* near);
  /// Of the particles in runs of bins those within reach, by index in their order; room for four more in found[].
  /// start[b]: first place of bin b, counted from the sphere's own.
  int (*neighbours)(const Binned& b, const int* start, const BinRun* runs, int count, const PairCutoff& reach,
                    int* found);
  /// Places of the pairs in contact; n a multiple of 4. Returns their number.
  int (*touching)(const double* packed, const NearPair* pairs, int n, int* contacts);
  void (*contact_forces)(const Spheres& s, const ContactStep& step, const double* packed, const NearPair* pairs,
                         const int* contacts, int n);
  /// The same for a wall and the n particles near it; springs: rows of three by particle; contacts: room for n + 1.
  void (*wall_forces)(const Spheres& s, const ContactStep& step, const PlaneWall& wall, const int* near, int n,
                      double* const* springs, int* contacts);
  /// f += mass g of the own particles in a group.
  void (*add_weight)(const Spheres& s, int group, const double g[3]);
  void (*kick)(const HalfStep& step);
};

/// Plain: the instructions that any processor of the kind has.
extern const ContactKernel kContactKernelPlain, kContactKernelAvx2, kContactKernelAvx512;

/// The kernel of that name, or with "auto" the fastest; null if there is none that this processor can run.
const ContactKernel* find_contact_kernel(const char* name);

}  // namespace twogrid
