// Loops over rows of contiguous values, compiled for the machine at hand.
#pragma once

/// Before a function of such loops: it exists for AVX2 and for any x86-64, and the running processor chooses. All that
/// it calls is inlined into it. Products and sums stay apart (-ffp-contract=off), so that both give the same bits.
/// Loops over more arrays than the compiler would check for overlap carry #pragma GCC ivdep: theirs are all distinct.
/// TWOGRID_VECTORISED_WIDE: for AVX-512 too. Clang does not join the two attributes; under the address sanitizer a file of
/// such functions takes minutes to compile: there, what the command line says.
#if defined(__clang__) || defined(__SANITIZE_ADDRESS__)
#define TWOGRID_VECTORISED
#define TWOGRID_VECTORISED_WIDE
#else
#define TWOGRID_VECTORISED __attribute__((target_clones("avx2", "default"), flatten))
#define TWOGRID_VECTORISED_WIDE __attribute__((target_clones("avx512f", "avx2", "default"), flatten))
#endif

namespace twogrid {

/// Four numbers at once, where a loop does not show the compiler what it could do. No function takes or returns one by
/// value: whether it travels in registers hangs on the instruction set.
typedef double Four __attribute__((vector_size(32)));
typedef long long FourIntegers __attribute__((vector_size(32)));

/// Four as they lie in arrays. (A vector of Four itself would not keep their alignment.)
struct alignas(32) FourNumbers {
  double at[4];
};
struct alignas(32) FourWholeNumbers {
  long long at[4];
};

inline void operator+=(FourNumbers& sum, const FourNumbers& a) {
  for (int c = 0; c < 4; ++c) sum.at[c] += a.at[c];
}
inline void operator+=(FourWholeNumbers& sum, const FourWholeNumbers& a) {
  for (int c = 0; c < 4; ++c) sum.at[c] += a.at[c];
}

/// Four numbers that lie anywhere in an array, as .row. (A vector type of less alignment won't do: clang forgets that through a reference.)
struct __attribute__((packed, aligned(8), may_alias)) FourInRow {
  Four row;
};
inline const FourInRow& four_at(const double* first) {
  return *reinterpret_cast<const FourInRow*>(first);
}
inline FourInRow& four_at(double* first) {
  return *reinterpret_cast<FourInRow*>(first);
}
/// Three numbers, and a fourth that means nothing. last: nothing may lie behind them.
inline void three_at(const double* first, bool last, Four& to) {
  if (last)
    to = Four{first[0], first[1], first[2], 0};
  else
    to = four_at(first).row;
}
struct __attribute__((packed, aligned(8), may_alias)) FourIntegersInRow {
  FourIntegers row;
};
inline const FourIntegersInRow& four_at(const long long* first) {
  return *reinterpret_cast<const FourIntegersInRow*>(first);
}
inline FourIntegersInRow& four_at(long long* first) {
  return *reinterpret_cast<FourIntegersInRow*>(first);
}

/// The nearest doubles. (No instruction before AVX-512 does this: the halves of the bits are put behind exponents of
/// 2^84 and 2^52, whose sum and the highest bit's sign are then taken away.)
inline void to_doubles(const FourIntegers& whole, Four& to) {
  typedef unsigned long long Bits __attribute__((vector_size(32)));
  const Bits m = (Bits)whole;
  const Four high = (Four)((m >> 32) ^ 0x4530000080000000ULL),
             low = (Four)((m & 0xffffffffULL) | 0x4330000000000000ULL);
  to = (high - (0x1p84 + 0x1p63 + 0x1p52)) + low;
}

/// m = max(m, a), number by number.
inline void keep_largest(Four& m, const Four& a) {
  m = a > m ? a : m;
}
/// |a|, number by number.
inline void size_of(const Four& a, Four& size) {
  size = (Four)((FourIntegers)a & 0x7fffffffffffffffLL);
}
inline void keep_largest_size(Four& m, const Four& a) {
  Four size;
  size_of(a, size);
  m = size > m ? size : m;
}

}  // namespace twogrid
