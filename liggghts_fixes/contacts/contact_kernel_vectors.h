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

/// Lanes of a (0 to 3) and b (4 to 7).
template <int i, int j, int k, int l>
inline V lanes(V a, V b) {
#if defined(__clang__)
  return __builtin_shufflevector(a, b, i, j, k, l);
#else
  return __builtin_shuffle(a, b, M{i, j, k, l});
#endif
}
inline I4 lanes(I4 a, I4 which) {
#if defined(__clang__)
  return I4{a[which[0]], a[which[1]], a[which[2]], a[which[3]]};
#else
  return __builtin_shuffle(a, which);
#endif
}

/// Four vectors of four become their transpose.
inline void transpose(V& a, V& b, V& c, V& d) {
  const V ab_even = lanes<0, 4, 2, 6>(a, b), ab_odd = lanes<1, 5, 3, 7>(a, b);
  const V cd_even = lanes<0, 4, 2, 6>(c, d), cd_odd = lanes<1, 5, 3, 7>(c, d);
  a = lanes<0, 1, 4, 5>(ab_even, cd_even);
  b = lanes<0, 1, 4, 5>(ab_odd, cd_odd);
  c = lanes<2, 3, 6, 7>(ab_even, cd_even);
  d = lanes<2, 3, 6, 7>(ab_odd, cd_odd);
}

struct V3 {
  V x, y, z;
};
inline V dot(const V3& a, const V3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace
}  // namespace twogrid
