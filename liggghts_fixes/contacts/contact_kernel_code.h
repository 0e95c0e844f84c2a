// The contact kernel's code, compiled once for each instruction set (contact_kernel_*.cpp): vectors of four doubles,
// which the compiler lowers to what there is. All functions are local to the file that includes this, and none of the
// standard library is called: an inline function compiled for one instruction set must not be linked into code for
// another.
//
//   contact_kernel_vectors.h   vectors of four numbers
//   contact_kernel_pairs.h     which pairs are near, which touch
//   contact_kernel_law.h       the law of contact
//   here                       forces of pairs and of walls
//   contact_kernel_motion.h    gravity, half a step of motion
#pragma once

#include "liggghts_fixes/contacts/contact_kernel.h"
#include "liggghts_fixes/contacts/contact_kernel_law.h"
#include "liggghts_fixes/contacts/contact_kernel_motion.h"
#include "liggghts_fixes/contacts/contact_kernel_pairs.h"
#include "liggghts_fixes/contacts/contact_kernel_vectors.h"

namespace twogrid {
namespace {

/// LIGGGHTS' flags of contact models that have seen the pair touch: normal and tangential.
constexpr int kTouched = 1 | 4;

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

}  // namespace
}  // namespace twogrid
