// Part of the contact kernel's code (contact_kernel_code.h). Vectors of four numbers.
#pragma once

namespace twogrid {
namespace {

typedef double V __attribute__((vector_size(32)));
typedef long long M __attribute__((vector_size(32)));

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

/// Four vectors of four become their transpose.
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

}  // namespace
}  // namespace twogrid
