// The contact kernel's code, compiled once for each instruction set (contact_kernel_*.cpp): vectors of four doubles,
// which the compiler lowers to what there is. All functions are local to the file that includes this, and none of the
// standard library is called: an inline function compiled for one instruction set must not be linked into code for
// another.
#pragma once

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {
namespace {

typedef double V __attribute__((vector_size(32)));
typedef long long M __attribute__((vector_size(32)));

/// LIGGGHTS' flags of contact models that have seen the pair touch: normal and tangential.
constexpr int kTouched = 1 | 4;

typedef int I4 __attribute__((vector_size(16)));
typedef float F4 __attribute__((vector_size(16)));

inline V load(const double* p) {
  V v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void store(double* p, V v) {
  __builtin_memcpy(p, &v, sizeof v);
}
inline V all(double a) {
  return V{a, a, a, a};
}
inline V select(M mask, V yes, V no) {
  return mask ? yes : no;
}
inline V absolute(V a) {
  return (V)((M)a & 0x7fffffffffffffffLL);
}
inline V root(V a) {
  V r;
  for (int l = 0; l < 4; ++l) r[l] = __builtin_sqrt(a[l]);
  return r;
}
/// Bit l: lane l of a comparison holds.
inline int bits(M m) {
#if defined(__AVX__)
  return __builtin_ia32_movmskpd256((V)m);
#else
  return int(m[0] & 1) | int(m[1] & 2) | int(m[2] & 4) | int(m[3] & 8);
#endif
}

inline int bits(I4 m) {
#if defined(__AVX__)
  return __builtin_ia32_movmskps((F4)m);
#else
  return (m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8);
#endif
}

/// ContactBatch vectors of four become their transpose.
inline void transpose(V& a, V& b, V& c, V& d) {
  const V ab_even = __builtin_shuffle(a, b, M{0, 4, 2, 6}), ab_odd = __builtin_shuffle(a, b, M{1, 5, 3, 7});
  const V cd_even = __builtin_shuffle(c, d, M{0, 4, 2, 6}), cd_odd = __builtin_shuffle(c, d, M{1, 5, 3, 7});
  a = __builtin_shuffle(ab_even, cd_even, M{0, 1, 4, 5});
  b = __builtin_shuffle(ab_odd, cd_odd, M{0, 1, 4, 5});
  c = __builtin_shuffle(ab_even, cd_even, M{2, 3, 6, 7});
  d = __builtin_shuffle(ab_odd, cd_odd, M{2, 3, 6, 7});
}

struct V3 {
  V x, y, z;
};
inline V dot(const V3& a, const V3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Distances of four pairs and the sums of their radii.
inline V3 distance(const double* packed, const NearPair* const p[4], V& radii) {
  const V minus_radius{1, 1, 1, -1};
  V d[4];
  for (int l = 0; l < 4; ++l) d[l] = load(packed + 4L * p[l]->i) - minus_radius * load(packed + 4L * p[l]->j);
  transpose(d[0], d[1], d[2], d[3]);
  radii = d[3];
  return {d[0], d[1], d[2]};
}

Drift pack(const Spheres& s, double* packed, const double* before) {
  V most = all(0);
  for (int i = 0; i < s.n_all; ++i) {
    const double* x = s.x + 3L * i;
    const V q{x[0], x[1], x[2], s.radius[i]};
    store(packed + 4L * i, q);
    const V moved = absolute(q - load(before + 4L * i));
    most = select(moved > most, moved, most);
  }
  return {__builtin_sqrt(most[0] * most[0] + most[1] * most[1] + most[2] * most[2]), most[3] != 0};
}

int near_pairs(const double* packed, int i, const int* j, int n, double gap, int* near) {
  const double *a = packed + 4L * i, x = a[0], y = a[1], z = a[2], reach = a[3] + gap;
  int found = 0;
  for (int k = 0; k < n; ++k) {
    const double* b = packed + 4L * j[k];
    const double dx = x - b[0], dy = y - b[1], dz = z - b[2], sum = reach + b[3];
    near[found] = k;
    found += dx * dx + dy * dy + dz * dz < sum * sum;
  }
  return found;
}

/// [bits]: the lanes of these bits, in order, then any.
constexpr I4 kFront[16] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {2, 0, 0, 0}, {0, 2, 0, 0},
                           {1, 2, 0, 0}, {0, 1, 2, 0}, {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0},
                           {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};

int neighbours(const Binned& b, const int* start, const BinRun* runs, int count, const PairCutoff& reach, int* found) {
  int n = 0;
  for (int run = 0; run < count; ++run) {
    const int last = start[runs[run].first + runs[run].bins];
    for (int k = start[runs[run].first]; k < last; k += 4) {
      const V dx = reach.x - load(b.x + k), dy = reach.y - load(b.y + k), dz = reach.z - load(b.z + k);
      const V most = (reach.r + load(b.r + k)) * reach.factor + reach.skin;
      I4 j;
      __builtin_memcpy(&j, b.index + k, sizeof j);
      const int near = bits(dx * dx + dy * dy + dz * dz <= most * most) & bits(j > reach.i) &
                       (last - k < 4 ? (1 << (last - k)) - 1 : 15);
      j = __builtin_shuffle(j, kFront[near]);
      __builtin_memcpy(found + n, &j, sizeof j);
      n += __builtin_popcount(near);
    }
  }
  return n;
}

int touching(const double* packed, const NearPair* pairs, int n, int* contacts) {
  int found = 0;
  for (int k = 0; k < n; k += 4) {
    const NearPair* const p[4] = {pairs + k, pairs + k + 1, pairs + k + 2, pairs + k + 3};
    V radii;
    const V3 d = distance(packed, p, radii);
    const int touch = bits(dot(d, d) < radii * radii);
    for (int l = 0; l < 4; ++l) {
      contacts[found] = k + l;
      found += touch >> l & 1;
    }
  }
  return found;
}

inline V effective_mass(const Spheres& s, const NearPair* const p[4], int frozen) {
  V mi, mj;
  for (int l = 0; l < 4; ++l) mi[l] = s.mass[p[l]->i], mj[l] = s.mass[p[l]->j];
  V m = mi * mj / (mi + mj);
  if (frozen)
    for (int l = 0; l < 4; ++l) {
      if (s.mask[p[l]->i] & frozen) m[l] = mj[l];
      if (s.mask[p[l]->j] & frozen) m[l] = mi[l];
    }
  return m;
}

/// Parameters of four contacts.
struct Laws {
  V kn, kt, gn, gt, mu;
  explicit Laws(const ContactLaw& l) : kn(all(l.kn)), kt(all(l.kt)), gn(all(l.gn)), gt(all(l.gt)), mu(all(l.mu)) {}
  Laws(const ContactLaw& a, const ContactLaw& b, const ContactLaw& c, const ContactLaw& d)
      : kn{a.kn, b.kn, c.kn, d.kn},
        kt{a.kt, b.kt, c.kt, d.kt},
        gn{a.gn, b.gn, c.gn, d.gn},
        gt{a.gt, b.gt, c.gt, d.gt},
        mu{a.mu, b.mu, c.mu, d.mu} {}
};

/// ContactBatch contacts: d from the other's centre (or wall) to the particle, e = d/r, v velocity against the other, w spins
/// times arms over r.
struct ContactBatch {
  V3 d, e, v, w;
  V overlap, meff;
};

/// Moves the springs; the force on the particle, normal part along e and tangential part.
inline void evaluate(const ContactStep& step, const Laws& law, const ContactBatch& c, V3& spring, V& fn, V3& ft) {
  const V dt = all(step.dt), zero = all(0);
  const M sign = (M)all(-0.0);
  auto minus = [&](V a) { return (V)((M)a ^ sign); };
  const V3 &e = c.e, &d = c.d, &w = c.w;
  const V vn = dot(c.v, e);
  const V3 vt{c.v.x - vn * e.x - (d.z * w.y - d.y * w.z), c.v.y - vn * e.y - (d.x * w.z - d.z * w.x),
              c.v.z - vn * e.z - (d.y * w.x - d.x * w.y)};
  const V eta_n = step.absolute ? law.gn : c.meff * law.gn, eta_t = step.absolute ? law.gt : c.meff * law.gt;
  fn = minus(eta_n) * vn + law.kn * c.overlap;
  if (step.push_only) fn = select(fn < zero, zero, fn);

  if (step.advance) {  // moved with the surfaces, turned into the contact's plane
    spring.x += vt.x * dt;
    spring.y += vt.y * dt;
    spring.z += vt.z * dt;
    const V out = dot(spring, e);
    spring.x -= out * e.x;
    spring.y -= out * e.y;
    spring.z -= out * e.z;
  }
  ft = {minus(law.kt * spring.x), minus(law.kt * spring.y), minus(law.kt * spring.z)};
  const V stretched = law.kt * root(dot(spring, spring)), friction = law.mu * absolute(fn);
  const M slips = stretched > friction;
  const V3 damped{ft.x - eta_t * vt.x, ft.y - eta_t * vt.y, ft.z - eta_t * vt.z};
  if (!bits(slips)) {
    ft = damped;
    return;
  }
  const V ratio = friction / stretched;
  const V3 slipping{ft.x * ratio, ft.y * ratio, ft.z * ratio};
  if (step.advance) {
    spring.x = select(slips, minus(slipping.x) / law.kt, spring.x);
    spring.y = select(slips, minus(slipping.y) / law.kt, spring.y);
    spring.z = select(slips, minus(slipping.z) / law.kt, spring.z);
  }
  ft = {select(slips, slipping.x, damped.x), select(slips, slipping.y, damped.y), select(slips, slipping.z, damped.z)};
}

inline V3 read_springs(double* const p[4]) {
  V q[4];
  for (int l = 0; l < 4; ++l) q[l] = V{p[l][0], p[l][1], p[l][2], 0};
  transpose(q[0], q[1], q[2], q[3]);
  return {q[0], q[1], q[2]};
}
inline void write_springs(double* const p[4], int lanes, const V3& spring) {
  V q[4] = {spring.x, spring.y, spring.z, all(0)};
  transpose(q[0], q[1], q[2], q[3]);
  for (int l = 0; l < lanes; ++l)
    for (int k = 0; k < 3; ++k) p[l][k] = q[l][k];
}

inline void store(double to[3][4], const V3& v) {
  store(to[0], v.x);
  store(to[1], v.y);
  store(to[2], v.z);
}
inline V3 force(V fn, const V3& e, const V3& ft) {
  return {fn * e.x + ft.x, fn * e.y + ft.y, fn * e.z + ft.z};
}
/// Torque of the tangential force at the end of an arm along -e.
inline V3 torque(V arm, const V3& e, const V3& ft) {
  const V back = (V)((M)arm ^ (M)all(-0.0));
  return {back * (e.y * ft.z - e.z * ft.y), back * (e.z * ft.x - e.x * ft.z), back * (e.x * ft.y - e.y * ft.x)};
}

template <bool kOneLaw>
void forces(const Spheres& s, const ContactStep& step, const double* packed, const NearPair* pairs, const int* contacts,
            int n) {
  Laws law(step.law[0]);
  for (int c = 0; c < n; c += 4) {
    const int lanes = n - c < 4 ? n - c : 4;  // the last group: idle lanes repeat the last contact
    const NearPair* p[4];
    double* springs[4];
    for (int l = 0; l < 4; ++l) {
      p[l] = pairs + contacts[l < lanes ? c + l : n - 1];
      springs[l] = p[l]->spring;
    }
    auto law_of = [&](int l) -> const ContactLaw& { return step.law[s.type[p[l]->i] * step.types + s.type[p[l]->j]]; };
    if (!kOneLaw) law = Laws(law_of(0), law_of(1), law_of(2), law_of(3));
    ContactBatch four;
    V radii;
    four.d = distance(packed, p, radii);
    const V3& d = four.d;
    const V r = root(dot(d, d)), rinv = 1.0 / r;
    four.e = {d.x * rinv, d.y * rinv, d.z * rinv};
    four.meff = effective_mass(s, p, step.frozen);
    four.overlap = radii - r;

    V v[4], wi[4], wj[4], ri, rj;
    for (int l = 0; l < 4; ++l) {
      const long i = 3L * p[l]->i, j = 3L * p[l]->j;
      v[l] = load(s.v + i) - load(s.v + j);
      wi[l] = load(s.omega + i);
      wj[l] = load(s.omega + j);
      ri[l] = packed[4L * p[l]->i + 3];
      rj[l] = packed[4L * p[l]->j + 3];
    }
    transpose(v[0], v[1], v[2], v[3]);
    transpose(wi[0], wi[1], wi[2], wi[3]);
    transpose(wj[0], wj[1], wj[2], wj[3]);
    const V arm_i = ri - 0.5 * four.overlap, arm_j = rj - 0.5 * four.overlap;
    four.v = {v[0], v[1], v[2]};
    four.w = {(arm_i * wi[0] + arm_j * wj[0]) * rinv, (arm_i * wi[1] + arm_j * wj[1]) * rinv,
              (arm_i * wi[2] + arm_j * wj[2]) * rinv};

    V3 spring = read_springs(springs), ft;
    V fn;
    evaluate(step, law, four, spring, fn, ft);
    if (step.advance) write_springs(springs, lanes, spring);
    double f[3][4], ti[3][4], tj[3][4];
    store(f, force(fn, four.e, ft));
    store(ti, torque(arm_i, four.e, ft));
    store(tj, torque(arm_j, four.e, ft));
    for (int l = 0; l < lanes; ++l) {
      const int i = p[l]->i, j = p[l]->j;
      for (int k = 0; k < 3; ++k) {
        s.f[3L * i + k] += f[k][l];
        s.torque[3L * i + k] += ti[k][l];
      }
      *p[l]->flags |= kTouched;
      if (j >= s.n_local) continue;
      for (int k = 0; k < 3; ++k) {
        s.f[3L * j + k] -= f[k][l];
        s.torque[3L * j + k] += tj[k][l];
      }
    }
  }
}

void contact_forces(const Spheres& s, const ContactStep& step, const double* packed, const NearPair* pairs,
                    const int* contacts, int n) {
  if (step.one_law)
    forces<true>(s, step, packed, pairs, contacts, n);
  else
    forces<false>(s, step, packed, pairs, contacts, n);
}

/// Gap between a sphere and a wall (m), negative where they overlap.
inline double gap_to(const PlaneWall& wall, double x, double r) {
  return x > wall.position ? x - wall.position - r : wall.position - x - r;
}

void wall_forces(const Spheres& s, const ContactStep& step, const PlaneWall& wall, const int* near, int n,
                 double* const* springs, int* contacts) {
  int found = 0;
  for (int k = 0; k < n; ++k) {
    const int i = near[k];
    if (!(s.mask[i] & wall.group)) continue;
    const double gap = gap_to(wall, s.x[3L * i + wall.normal], s.radius[i]);
    if (gap <= 0)
      contacts[found++] = i;
    else if (gap <= wall.reach)
      springs[i][0] = springs[i][1] = springs[i][2] = 0;
  }

  Laws law(step.law[0]);
  const V none = all(-0.0);
  for (int c = 0; c < found; c += 4) {
    const int lanes = found - c < 4 ? found - c : 4;
    int p[4];
    double* spring_of[4];
    V radius, overlap, mass, away, v[4], omega[4];
    for (int l = 0; l < 4; ++l) {
      const int i = p[l] = contacts[l < lanes ? c + l : found - 1];
      const double x = s.x[3L * i + wall.normal];
      radius[l] = s.radius[i];
      overlap[l] = -gap_to(wall, x, s.radius[i]);
      away[l] = -(wall.position - x);
      mass[l] = s.mass[i];
      spring_of[l] = springs[i];
      v[l] = load(s.v + 3L * i);
      omega[l] = load(s.omega + 3L * i);
    }
    auto law_of = [&](int l) -> const ContactLaw& { return step.law[s.type[p[l]] * step.types + wall.type]; };
    if (!step.one_law) law = Laws(law_of(0), law_of(1), law_of(2), law_of(3));
    transpose(v[0], v[1], v[2], v[3]);
    transpose(omega[0], omega[1], omega[2], omega[3]);
    const V r = radius - overlap, rinv = 1.0 / r, arm = radius - 0.5 * overlap;
    ContactBatch four;
    four.d = {wall.normal == 0 ? away : none, wall.normal == 1 ? away : none, wall.normal == 2 ? away : none};
    four.e = {four.d.x * rinv, four.d.y * rinv, four.d.z * rinv};
    four.v = {v[0], v[1], v[2]};
    four.w = {arm * omega[0] * rinv, arm * omega[1] * rinv, arm * omega[2] * rinv};
    four.overlap = radius - r;
    four.meff = mass;

    V3 spring = read_springs(spring_of), ft;
    V fn;
    evaluate(step, law, four, spring, fn, ft);
    if (step.advance) write_springs(spring_of, lanes, spring);
    double f[3][4], t[3][4];
    store(f, force(fn, four.e, ft));
    store(t, torque(arm, four.e, ft));
    for (int l = 0; l < lanes; ++l)
      for (int k = 0; k < 3; ++k) {
        s.f[3L * p[l] + k] += f[k][l];
        s.torque[3L * p[l] + k] += t[k][l];
      }
  }
}

/// ContactBatch numbers, each three times: factors of four particles' vectors.
struct Threefold {
  V low, middle, high;
  explicit Threefold(V a)
      : low(__builtin_shuffle(a, M{0, 0, 0, 1})),
        middle(__builtin_shuffle(a, M{1, 1, 2, 2})),
        high(__builtin_shuffle(a, M{2, 3, 3, 3})) {}
};
/// a += factor b for the vectors of four particles.
inline void add(double* a, const Threefold& factor, const double* b) {
  store(a, load(a) + factor.low * load(b));
  store(a + 4, load(a + 4) + factor.middle * load(b + 4));
  store(a + 8, load(a + 8) + factor.high * load(b + 8));
}
inline bool all_in(const int* mask, int group) {
  return (mask[0] & group) && (mask[1] & group) && (mask[2] & group) && (mask[3] & group);
}

void add_weight(const Spheres& s, int group, const double g[3]) {
  const double across[12] = {g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1], g[2]};
  for (int i = 0; i < s.n_local; i += 4) {
    double* f = s.f + 3L * i;
    if (i + 4 <= s.n_local && all_in(s.mask + i, group)) {
      add(f, Threefold(load(s.mass + i)), across);
      continue;
    }
    for (int l = i; l < s.n_local && l < i + 4; ++l, f += 3)
      if (s.mask[l] & group)
        for (int k = 0; k < 3; ++k) f[k] += s.mass[l] * g[k];
  }
}

template <bool kDrift>
void move(const HalfStep& step) {
  const double spin_h = step.h / 0.4;  // of a sphere: I = 0.4 m r^2
  const double dts[4] = {step.dt, step.dt, step.dt, step.dt};
  for (int i = 0; i < step.n; i += 4) {
    double *x = step.x + 3L * i, *v = step.v + 3L * i, *omega = step.omega + 3L * i;
    const double *f = step.f + 3L * i, *torque = step.torque + 3L * i;
    if (i + 4 <= step.n && all_in(step.mask + i, step.group)) {
      const V m = load(step.mass + i), r = load(step.radius + i);
      add(v, Threefold(step.h / (m * step.mass_factor)), f);
      if (kDrift) add(x, Threefold(load(dts)), v);
      add(omega, Threefold(spin_h / (r * r * m)), torque);
      continue;
    }
    for (int l = i; l < step.n && l < i + 4; ++l, x += 3, v += 3, omega += 3, f += 3, torque += 3) {
      if (!(step.mask[l] & step.group)) continue;
      const double m = step.mass[l], r = step.radius[l];
      const double per_mass = step.h / (m * step.mass_factor), per_inertia = spin_h / (r * r * m);
      for (int k = 0; k < 3; ++k) {
        v[k] += per_mass * f[k];
        if (kDrift) x[k] += step.dt * v[k];
        omega[k] += per_inertia * torque[k];
      }
    }
  }
}

void kick(const HalfStep& step) {
  if (step.dt != 0)
    move<true>(step);
  else
    move<false>(step);
}

}  // namespace
}  // namespace twogrid
