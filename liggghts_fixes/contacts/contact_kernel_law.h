// Part of the contact kernel's code (contact_kernel_code.h). The law of contact, for four contacts at a time.
#pragma once

#include "liggghts_fixes/contacts/contact_kernel.h"
#include "liggghts_fixes/contacts/contact_kernel_vectors.h"

namespace twogrid {
namespace {

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

/// Four contacts: d from the other's centre (or wall) to the particle, e = d/r, v velocity against the other, w spins
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

}  // namespace
}  // namespace twogrid
