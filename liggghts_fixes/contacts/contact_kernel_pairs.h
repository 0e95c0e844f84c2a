// Part of the contact kernel's code (contact_kernel_code.h). Which pairs of spheres are near each other, and
// which touch.
#pragma once

#include "liggghts_fixes/contacts/contact_kernel.h"
#include "liggghts_fixes/contacts/contact_kernel_vectors.h"

namespace twogrid {
namespace {

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
      j = lanes(j, kFront[near]);
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

}  // namespace
}  // namespace twogrid
