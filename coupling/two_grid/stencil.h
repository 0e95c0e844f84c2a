// The nodes that one particle writes to or reads from, and their weights: a product of one short list a direction.
//
// Values at nodes that belong together lie in groups of four, one row of groups a node: a corner is then one load a
// group. A particle's four whole numbers are split among nodes so that the parts' sum is exactly they.
#pragma once

#include <algorithm>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/parallel/vectorised.h"
#include "coupling/two_grid/fixed_point.h"

namespace twogrid {

struct Stencil {
  static constexpr int kMax = 64;  ///< nodes a direction
  Int3 lo;                         ///< first node, an index of the window
  Int3 n;                          ///< nodes a direction
  Int3 home;                       ///< the node that holds the particle's centre, an index of the window
  double w[3][kMax];               ///< weights; each direction's sum is 1

  bool single() const { return n[0] == 1 && n[1] == 1 && n[2] == 1; }
};

/// The two nodes a direction between whose centres a particle lies, eight in all.
struct Corners {
  double w[3];          ///< weight of the upper node; the lower one has the rest
  std::ptrdiff_t at;    ///< place of the lowest of the eight in a field of the window
  std::ptrdiff_t home;  ///< place of the one that holds the particle's centre
};

/// The nodes of a particle where bodies stand: none that is closed, or that its own node doesn't see. Kept by whoever goes
/// through many particles, so that nothing is allocated for each.
struct SeenNodes {
  int n = 0;
  std::ptrdiff_t home = 0;         ///< place of the node that holds the centre, or else of the nearest open one
  std::vector<std::ptrdiff_t> at;  ///< places; some may be the same
  std::vector<double> w;           ///< their sum is 1
  Stencil all;                     ///< as there would be without bodies
};

/// Where particles read or write, found once a coupling.
struct Places {
  std::vector<std::ptrdiff_t> node;  ///< a single node each
  std::vector<Corners> corners;      ///< or between node centres; else nothing is kept
};

/// Places in a field of a window: x runs fastest.
struct WindowShape {
  Int3 lo;                   ///< index of the first node
  std::ptrdiff_t row, slab;  ///< nodes a row, nodes a slab
  Int3 up;                   ///< from a node to the upper one of a pair; 0 where there is one node in that direction

  std::ptrdiff_t place(const Int3& node) const {
    return (node[0] - lo[0]) + row * (node[1] - lo[1]) + slab * (node[2] - lo[2]);
  }
  std::ptrdiff_t first(const Stencil& s) const { return place(s.lo); }
};

/// Where a bed ends, the mean over nodes on either side is no void fraction and no velocity of any particle's
/// surroundings: of a particle inside, the drag would fall short. So what a particle sees is interpolated between nodes
/// that are about as full as its own, `home`: a node's weight is multiplied by a factor that is 1 where it holds over
/// kFull of the solids of home, 0 below kEmpty of them, linear between. Fuller nodes keep their weight.
struct LikeHome {
  static constexpr double kFull = 0.7, kEmpty = 0.3;
  double solids;  ///< of home
  /// Void fraction up to which a node has its weight in full.
  double full_up_to() const { return 1 - kFull * solids; }
  double factor(double eps) const {
    const double share = (1 - eps - kEmpty * solids) / ((kFull - kEmpty) * solids);
    return std::min(std::max(share, 0.0), 1.0);
  }
};

/// Weighted means of kGroups groups at once.
template <int kGroups>
inline void gather(const Corners& c, const WindowShape& shape, const FourNumbers* field, Four* out) {
  const FourNumbers* const first = field + kGroups * c.at;
  const std::ptrdiff_t x = kGroups * shape.up[0], y = kGroups * shape.up[1], z = kGroups * shape.up[2];
  const FourNumbers* const at[4] = {first, first + y, first + z, first + y + z};
  for (int g = 0; g < kGroups; ++g) {
    Four row[4];
    for (int q = 0; q < 4; ++q) {
      const Four left = four_at(at[q][g].at).row, right = four_at(at[q][g + x].at).row;
      row[q] = left + c.w[0] * (right - left);
    }
    const Four low = row[0] + c.w[1] * (row[1] - row[0]), high = row[2] + c.w[1] * (row[3] - row[2]);
    out[g] = low + c.w[2] * (high - low);
  }
}

template <int kGroups>
inline void gather(const Stencil& s, const WindowShape& shape, const FourNumbers* field, Four* out) {
  for (int g = 0; g < kGroups; ++g) out[g] = Four{0, 0, 0, 0};
  const std::ptrdiff_t first = shape.first(s);
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j) {
      const double wjk = s.w[1][j] * s.w[2][k];
      const FourNumbers* node = field + kGroups * (first + shape.row * j + shape.slab * k);
      for (int i = 0; i < s.n[0]; ++i, node += kGroups) {
        const double w = s.w[0][i] * wjk;
        for (int g = 0; g < kGroups; ++g) out[g] += w * four_at(node[g].at).row;
      }
    }
}

template <int kGroups>
inline void gather(std::ptrdiff_t node, const WindowShape&, const FourNumbers* field, Four* out) {
  for (int g = 0; g < kGroups; ++g) out[g] = four_at(field[kGroups * node + g].at).row;
}

/// Weighted means of kGroups groups over nodes listed one by one.
template <int kGroups, class Nodes>
inline void gather_list(const Nodes& s, const FourNumbers* field, Four* out) {
  for (int g = 0; g < kGroups; ++g) {
    out[g] = Four{0, 0, 0, 0};
    for (int q = 0; q < s.n; ++q) out[g] += s.w[q] * four_at(field[kGroups * s.at[q] + g].at).row;
  }
}
template <int kGroups>
inline void gather(const SeenNodes& s, const WindowShape&, const FourNumbers* field, Four* out) {
  gather_list<kGroups>(s, field, out);
}

/// What a particle sees, group 0 of kGroups (component 3: void fraction): interpolated between nodes like its own. out:
/// the plain mean, as gather() gives it, which holds where no node is emptier.
template <int kGroups>
inline void see_like_home(const Corners& c, const WindowShape& shape, const FourNumbers* field, Four& out) {
  const FourNumbers* const first = field + kGroups * c.at;
  const std::ptrdiff_t up[3] = {kGroups * shape.up[0], kGroups * shape.up[1], kGroups * shape.up[2]};
  double emptiest = 0;
  for (int q = 0; q < 8; ++q)
    emptiest = std::max(emptiest, first[(q & 1) * up[0] + (q >> 1 & 1) * up[1] + (q >> 2) * up[2]].at[3]);
  const LikeHome like{1 - field[kGroups * c.home].at[3]};
  if (emptiest <= like.full_up_to()) return;
  Four sum{0, 0, 0, 0};
  double weights = 0;
  for (int q = 0; q < 8; ++q) {
    const int x = q & 1, y = q >> 1 & 1, z = q >> 2;
    const Four node = four_at(first[x * up[0] + y * up[1] + z * up[2]].at).row;
    const double w =
        (x ? c.w[0] : 1 - c.w[0]) * (y ? c.w[1] : 1 - c.w[1]) * (z ? c.w[2] : 1 - c.w[2]) * like.factor(node[3]);
    sum += w * node;
    weights += w;
  }
  out = sum / weights;
}

template <int kGroups>
inline void see_like_home(const Stencil& s, const WindowShape& shape, const FourNumbers* field, Four& out) {
  const LikeHome like{1 - field[kGroups * shape.place(s.home)].at[3]};
  const std::ptrdiff_t first = shape.first(s);
  double emptiest = 0;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j)
      for (int i = 0; i < s.n[0]; ++i)
        emptiest = std::max(emptiest, field[kGroups * (first + i + shape.row * j + shape.slab * k)].at[3]);
  if (emptiest <= like.full_up_to()) return;
  Four sum{0, 0, 0, 0};
  double weights = 0;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j)
      for (int i = 0; i < s.n[0]; ++i) {
        const Four node = four_at(field[kGroups * (first + i + shape.row * j + shape.slab * k)].at).row;
        const double w = s.w[0][i] * s.w[1][j] * s.w[2][k] * like.factor(node[3]);
        sum += w * node;
        weights += w;
      }
  if (weights > 0) out = sum / weights;
}

template <int kGroups>
inline void see_like_home(const SeenNodes& s, const WindowShape&, const FourNumbers* field, Four& out) {
  const LikeHome like{1 - field[kGroups * s.home].at[3]};
  double emptiest = 0;
  for (int q = 0; q < s.n; ++q) emptiest = std::max(emptiest, field[kGroups * s.at[q]].at[3]);
  if (emptiest <= like.full_up_to()) return;
  Four sum{0, 0, 0, 0};
  double weights = 0;
  for (int q = 0; q < s.n; ++q) {
    const Four node = four_at(field[kGroups * s.at[q]].at).row;
    const double w = s.w[q] * like.factor(node[3]);
    sum += w * node;
    weights += w;
  }
  if (weights > 0) out = sum / weights;
}

template <int kGroups>
inline void see_like_home(std::ptrdiff_t, const WindowShape&, const FourNumbers*, Four&) {}

/// upper = the whole numbers nearest to w total, lower = the rest.
template <class T>
inline void split(double w, const T& total, T& lower, T& upper) {
  upper = (w * total + kWhole) - kWhole;
  lower = total - upper;
}

/// Adds whole numbers to a node.
inline void add_whole(const Four& part, FourWholeNumbers& node) {
  four_at(node.at).row += (FourIntegers)(part + kWhole) - kWholeBits;
}

/// Adds the whole numbers `total`, split by the weights, so that exactly `total` is added.
inline void scatter(const Corners& c, const WindowShape& shape, const Four& total, FourWholeNumbers* field) {
  Four z[2], y[2], x[2];
  split(c.w[2], total, z[0], z[1]);
  for (int k = 0; k < 2; ++k) {
    split(c.w[1], z[k], y[0], y[1]);
    for (int j = 0; j < 2; ++j) {
      split(c.w[0], y[j], x[0], x[1]);
      FourWholeNumbers* const node = field + c.at + j * shape.up[1] + k * shape.up[2];
      add_whole(x[0], node[0]);
      add_whole(x[1], node[shape.up[0]]);
    }
  }
}

/// The same; what rounding leaves over goes to the node of the largest weight.
inline void scatter(const Stencil& s, const WindowShape& shape, const Four& total, FourWholeNumbers* field) {
  const std::ptrdiff_t first = shape.first(s);
  Four rest = total;
  double largest = -1;
  std::ptrdiff_t at = first;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j) {
      const double wjk = s.w[1][j] * s.w[2][k];
      const std::ptrdiff_t m = first + shape.row * j + shape.slab * k;
      for (int i = 0; i < s.n[0]; ++i) {
        const double w = s.w[0][i] * wjk;
        Four part, others;
        split(w, total, others, part);
        add_whole(part, field[m + i]);
        rest -= part;
        if (w > largest) largest = w, at = m + i;
      }
    }
  add_whole(rest, field[at]);
}

inline void scatter(std::ptrdiff_t node, const WindowShape&, const Four& total, FourWholeNumbers* field) {
  add_whole(total, field[node]);
}

/// Over nodes listed one by one; what rounding leaves over goes to the node of the largest weight, so that exactly
/// `total` is added.
template <class Nodes>
inline void scatter_list(const Nodes& s, const Four& total, FourWholeNumbers* field) {
  Four rest = total;
  int most = 0;
  for (int q = 0; q < s.n; ++q) {
    Four others, part;
    split(s.w[q], total, others, part);
    add_whole(part, field[s.at[q]]);
    rest -= part;
    if (s.w[q] > s.w[most]) most = q;
  }
  add_whole(rest, field[s.at[most]]);
}
inline void scatter(const SeenNodes& s, const WindowShape&, const Four& total, FourWholeNumbers* field) {
  scatter_list(s, total, field);
}

/// One whole number a particle.
inline void scatter(const SeenNodes& s, const WindowShape&, double total, long long* field) {
  double rest = total;
  int most = 0;
  for (int q = 0; q < s.n; ++q) {
    double others, part;
    split(s.w[q], total, others, part);
    field[s.at[q]] += static_cast<long long>(part);
    rest -= part;
    if (s.w[q] > s.w[most]) most = q;
  }
  field[s.at[most]] += static_cast<long long>(rest);
}
inline void scatter(const Corners& c, const WindowShape& shape, double total, long long* field) {
  double z[2], y[4];
  split(c.w[2], total, z[0], z[1]);
  split(c.w[1], z[0], y[0], y[1]);
  split(c.w[1], z[1], y[2], y[3]);
  Four lower, upper;
  split(c.w[0], Four{y[0], y[1], y[2], y[3]}, lower, upper);
  const FourIntegers low = (FourIntegers)(lower + kWhole) - kWholeBits,
                     high = (FourIntegers)(upper + kWhole) - kWholeBits;
  long long* const first = field + c.at;
  long long* const row[4] = {first, first + shape.up[1], first + shape.up[2], first + shape.up[1] + shape.up[2]};
  for (int q = 0; q < 4; ++q) {
    row[q][0] += low[q];
    row[q][shape.up[0]] += high[q];
  }
}

/// Nodes of a place, and weights between those like the particle's own.
struct WeightsLikeHome {
  int n;
  std::ptrdiff_t at[8];
  double w[8];  ///< their sum is 1
};

/// eps: component 3 of the window's nodes, `stride` apart.
inline WeightsLikeHome weights_like_home(const Corners& c, const WindowShape& shape, const FourNumbers* eps,
                                         int stride) {
  WeightsLikeHome like{8, {}, {}};
  const LikeHome home{1 - eps[stride * c.home].at[3]};
  double sum = 0;
  for (int q = 0; q < 8; ++q) {
    const int x = q & 1, y = q >> 1 & 1, z = q >> 2;
    like.at[q] = c.at + x * shape.up[0] + y * shape.up[1] + z * shape.up[2];
    const double e = eps[stride * like.at[q]].at[3];
    like.w[q] = (x ? c.w[0] : 1 - c.w[0]) * (y ? c.w[1] : 1 - c.w[1]) * (z ? c.w[2] : 1 - c.w[2]) *
                (e <= home.full_up_to() ? 1.0 : home.factor(e));
    sum += like.w[q];
  }
  for (double& w : like.w) w /= sum;
  return like;
}
inline WeightsLikeHome weights_like_home(const SeenNodes& s, const WindowShape&, const FourNumbers* eps, int stride) {
  WeightsLikeHome like{s.n, {}, {}};
  const LikeHome home{1 - eps[stride * s.home].at[3]};
  double sum = 0;
  for (int q = 0; q < s.n; ++q) {
    like.at[q] = s.at[q];
    const double e = eps[stride * s.at[q]].at[3];
    sum += like.w[q] = s.w[q] * (e <= home.full_up_to() ? 1.0 : home.factor(e));
  }
  for (double& w : like.w) w /= sum;
  return like;
}
inline WeightsLikeHome weights_like_home(std::ptrdiff_t node, const WindowShape&, const FourNumbers*, int) {
  return {1, {node}, {1}};
}

/// Weighted means of kGroups groups by such weights.
template <int kGroups>
inline void gather(const WeightsLikeHome& like, const FourNumbers* field, Four* out) {
  gather_list<kGroups>(like, field, out);
}

/// Adds the whole numbers `total`, split by such weights.
inline void scatter(const WeightsLikeHome& like, const Four& total, FourWholeNumbers* field) {
  scatter_list(like, total, field);
}

/// Adds `total` units, split by the weights; what rounding leaves over goes to the node of the largest weight, so that
/// exactly `total` is added.
inline void scatter(const Stencil& s, long long total, Array3<long long>& field) {
  const std::ptrdiff_t first = field.index(s.lo[0], s.lo[1], s.lo[2]);
  if (s.single()) {
    field.data()[first] += total;
    return;
  }
  const double q = double(total);
  long long rest = total;
  double largest = -1;
  std::ptrdiff_t at = first;
  for (int k = 0; k < s.n[2]; ++k)
    for (int j = 0; j < s.n[1]; ++j) {
      const double wjk = s.w[1][j] * s.w[2][k];
      const std::ptrdiff_t m = field.index(s.lo[0], s.lo[1] + j, s.lo[2] + k);
      for (int i = 0; i < s.n[0]; ++i) {
        const double w = s.w[0][i] * wjk;
        const long long part = static_cast<long long>(w * q);
        field.data()[m + i] += part;
        rest -= part;
        if (w > largest) largest = w, at = m + i;
      }
    }
  field.data()[at] += rest;
}

}  // namespace twogrid
