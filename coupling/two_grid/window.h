// The nodes that the particles of one rank can touch. A rank's particles lie in its brick of the particle
// decomposition, and up to `reach` outside it; its nodes, cut for the fluid, may be others. The window is a box of
// nodes that covers the brick, the reach and the width of the weights. Values come from the owners (bring) and sums go
// to them (add).
//
// Indices are not wrapped: in a periodic direction node i and node i + n are images of one node. At a side that is not
// periodic the window ends with the grid, and the outermost node takes what lies beyond it.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cfd/parallel/block_exchange.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/particle_grid.h"
#include "coupling/two_grid/stencil.h"

namespace twogrid {

/// How a particle spreads over nodes.
enum class Spread {
  kCell,    ///< all to the node that holds the centre: lo <= x < hi
  kLinear,  ///< linear between node centres, tensor product; at a wall the missing outer node's weight stays inside
  kKernel,  ///< quadratic B-spline of full width w, integrated over each node; at a wall scaled up to its inner part
  kCube     ///< uniform over a cube of edge w; at a wall the cube is shifted inside
};

/// Where a rank's particles may be.
struct ParticleRegion {
  Vec3 lo{0, 0, 0}, hi{0, 0, 0};  ///< brick of the particle decomposition (m)
  double reach = 0;               ///< how far outside it a particle may lie (m)
};

class Window {
 public:
  /// One direction: coordinates of the nodes of the window.
  struct Span {
    int lo = 0, hi = 0;          ///< nodes [lo, hi)
    std::vector<double> node;    ///< low sides, and the high side of the last: hi - lo + 1
    std::vector<double> edge;    ///< the same, but no x lies below the first or above the last (not a number)
    std::vector<double> centre;  ///< hi - lo
    /// Uniform: centres lie at pair_origin + k / per_gap, k whole and not negative. The same origin on all ranks, so
    /// that weights are the same to the last bit. Pairs of the window begin at first_pair to last_pair; its last centre
    /// is end_pair.
    double pair_origin = 0, per_gap = 0, first_pair = 0, last_pair = 0, end_pair = 0;
    double domain_lo = 0, domain_hi = 0;
    double x_lo = 0, x_hi = 0;  ///< where this rank's particles may be
    bool periodic = false, uniform = false;
    double inverse_width = 0;  ///< mean nodes per metre

    /// Index of the node that holds x, lo <= x < hi; the outermost node of the window where x lies beyond. (Not a
    /// number: the first. Such a particle ends the run, but not before all have been looked at.)
    int find(double x) const {
      if (!uniform) return find_stretched(x);
      const double last = hi - lo - 1;
      const int i = int(std::min(std::max(0.0, (x - node[0]) * inverse_width), last));
      // Rounding of the product must not put x on the wrong side of a node. (No branches: they can't be foreseen.)
      return i + lo + int(x >= edge[i + 1]) - int(x < edge[i]);
    }
    int find_stretched(double x) const;
    /// Of the two nodes between whose centres x lies: the lower one, from the window's first on, and the weight of the
    /// upper one. Beyond the outermost centre all weight is with that node. (A single node: it, and zero.)
    void between(double x, int& lower, double& w) const {
      if (!uniform) return between_stretched(x, lower, w);
      const double t = std::min(std::max(first_pair, (x - pair_origin) * per_gap), end_pair);
      const double pair = std::min(double(int(t)), last_pair);
      lower = int(pair - first_pair);
      w = t - pair;
    }
    void between_stretched(double x, int& lower, double& w) const;
    double low(int i) const { return node[i - lo]; }
    double high(int i) const { return node[i + 1 - lo]; }
  };

  Window() = default;
  /// width: of the kernel or cube, or diameter of the largest sphere to be intersected (m). Collective.
  /// Throws std::invalid_argument when more than Stencil::kMax nodes would be spanned.
  Window(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const ParticleRegion& region, Spread spread,
         double width);

  const Box& box() const { return box_; }
  const Span& span(int d) const { return span_[d]; }
  Spread spread() const { return spread_; }
  double width() const { return width_; }
  /// Whether the rank may hold a particle at x (else its weights would be cut off).
  bool covers(const double x[3]) const {
    return x[0] >= span_[0].x_lo && x[0] <= span_[0].x_hi && x[1] >= span_[1].x_lo && x[1] <= span_[1].x_hi &&
           x[2] >= span_[2].x_lo && x[2] <= span_[2].x_hi;
  }
  /// Weights of a particle centred at x.
  void weights(const double x[3], Stencil& s) const {
    if (spread_ != Spread::kCell) {
      wide_weights(x, s);
      return;
    }
    for (int d = 0; d < 3; ++d) s.lo[d] = s.home[d] = span_[d].find(x[d]), s.n[d] = 1, s.w[d][0] = 1;
  }

  /// Bodies stand in the grid: weights come by see(), nodes by open_node().
  bool cut() const { return cut_; }
  /// The nodes of weights(), each that is closed or not seen from the particle's own node replaced by that.
  void see(const double x[3], SeenNodes& s) const;
  /// Place of the open node that holds x or else lies nearest to it, within OpenNodes::search(); without any, of the
  /// closed one that holds x.
  std::ptrdiff_t open_node(const double x[3]) const {
    const std::ptrdiff_t own = node(x);
    return is_open(own) ? own : nearest_open(x, own);
  }
  bool is_open(std::ptrdiff_t place) const;
  /// Places of the nodes of a box of the window, x fastest, those that `home` doesn't see replaced by its own.
  void seen_from(const Int3& home, const Int3& lo, const Int3& n, std::vector<std::ptrdiff_t>& at) const;

  /// Place in a field of the window of the node that holds x.
  std::ptrdiff_t node(const double x[3]) const {
    return place(span_[0].find(x[0]) - box_.lo[0], span_[1].find(x[1]) - box_.lo[1], span_[2].find(x[2]) - box_.lo[2]);
  }
  /// Weights for kLinear.
  Corners corners(const double x[3]) const {
    Corners c;
    int i[3];
    int home[3];
    for (int d = 0; d < 3; ++d) {
      span_[d].between(x[d], i[d], c.w[d]);
      home[d] = span_[d].uniform ? i[d] + (c.w[d] >= 0.5) : span_[d].find(x[d]) - box_.lo[d];
    }
    c.at = place(i[0], i[1], i[2]);
    c.home = place(home[0], home[1], home[2]);
    return c;
  }
  /// All directions uniform: node() of four particles at once, from one component of their positions at a time.
  struct UniformCells {
    struct Direction {
      double first, per_width, last, stride;
    } d[3];
  };
  UniformCells uniform_cells() const {
    UniformCells c;
    const WindowShape s = shape();
    for (int d = 0; d < 3; ++d) {
      const Span& a = span_[d];
      const std::ptrdiff_t stride = d == 0 ? 1 : d == 1 ? s.row : s.slab;
      c.d[d] = {a.node[0], a.inverse_width, double(a.hi - a.lo - 1), double(stride)};
    }
    return c;
  }
  /// Adds the place along one direction to `at`; near is not zero where x lies so near a side of its node, or beyond
  /// the window, that rounding has a say.
  static void add_place(const UniformCells::Direction& c, const Four& x, Four& at, FourIntegers& near) {
    constexpr double kNear = 1e-4;
    const double end = c.last + 1;
    Four t = (x - c.first) * c.per_width;
    t = t > 0.0 ? t : Four{0, 0, 0, 0};
    t = t < end ? t : Four{end, end, end, end};
    Four i;
    truncate(t, i);
    i = i < c.last ? i : Four{c.last, c.last, c.last, c.last};
    const Four within = t - i;
    near |= (within < kNear) | (within > 1 - kNear);
    at += i * c.stride;
  }
  /// The same for corners, as Span::between().
  struct UniformPairs {
    Four origin, per_gap, first, last, end, stride;
  };
  bool uniform() const { return span_[0].uniform && span_[1].uniform && span_[2].uniform; }
  UniformPairs uniform_pairs() const {
    UniformPairs p;
    const WindowShape s = shape();
    for (int d = 0; d < 3; ++d) {
      const Span& a = span_[d];
      p.origin[d] = a.pair_origin, p.per_gap[d] = a.per_gap;
      p.first[d] = a.first_pair, p.last[d] = a.last_pair, p.end[d] = a.end_pair;
      p.stride[d] = s.up[d];
    }
    p.origin[3] = p.per_gap[3] = p.first[3] = p.last[3] = p.end[3] = p.stride[3] = 0;
    return p;
  }
  static void corners(const UniformPairs& a, const Four& x, Corners& c) {
    Four t = (x - a.origin) * a.per_gap;
    t = t > a.first ? t : a.first;
    t = t < a.end ? t : a.end;
    Four pair;
    truncate(t, pair);
    pair = pair < a.last ? pair : a.last;
    const Four w = t - pair, at = (pair - a.first) * a.stride, home = at + (w >= 0.5 ? a.stride : Four{0, 0, 0, 0});
    for (int d = 0; d < 3; ++d) c.w[d] = w[d];
    c.at = std::ptrdiff_t(at[0] + at[1] + at[2]);
    c.home = std::ptrdiff_t(home[0] + home[1] + home[2]);
  }
  WindowShape shape() const {
    const int row = box_.size(0), slab = row * box_.size(1);
    return {box_.lo, row, slab, {row > 1, box_.size(1) > 1 ? row : 0, box_.size(2) > 1 ? slab : 0}};
  }

  /// Window <- owners. Collective.
  template <class T>
  void bring(const std::vector<const Array3<T>*>& owner, const std::vector<Array3<T>*>& window) const {
    exchange_.bring<T>(owner, window);
  }
  /// In groups; where own nodes lie within the window, both may be one memory.
  void bring(const std::vector<Slot<FourNumbers>>& owner, const std::vector<Slot<FourNumbers>>& window) const {
    exchange_.bring<FourNumbers>(owner, window);
  }
  void add(const std::vector<Slot<FourWholeNumbers>>& window, const std::vector<Slot<FourWholeNumbers>>& owner) const {
    exchange_.add<FourWholeNumbers>(window, owner);
  }
  /// Owners += windows. Collective.
  void add(const std::vector<const Array3<long long>*>& window, const std::vector<Array3<long long>*>& owner) const {
    exchange_.add<long long>(window, owner);
  }

 private:
  static void truncate(const Four& t, Four& whole) {
    typedef int FourInt __attribute__((vector_size(16)));
    whole = __builtin_convertvector(__builtin_convertvector(t, FourInt), Four);
  }
  void wide_weights(const double x[3], Stencil& s) const;
  void take_sight(const OpenNodes& nodes);
  void see_corners(const double x[3], SeenNodes& s) const;
  std::ptrdiff_t nearest_open(const double x[3], std::ptrdiff_t own) const;
  std::ptrdiff_t place(int i, int j, int k) const {
    return i + std::ptrdiff_t(box_.size(0)) * (j + std::ptrdiff_t(box_.size(1)) * k);
  }

  Box box_;
  std::array<Span, 3> span_;
  Spread spread_ = Spread::kCell;
  double width_ = 0;
  BlockExchange exchange_;
  bool cut_ = false;
  Int3 search_{0, 0, 0};
  std::vector<std::uint32_t> sight_;    // of the window's nodes, as OpenNodes has it
  mutable std::vector<Int3> frontier_;  // scratch of seen_from()
  mutable std::vector<char> reached_;   // the same
};

/// Where particles lie: nodes for kCell, corners for kLinear; nothing for other weights. Where bodies stand, open nodes
/// for kCell, else nothing. Local.
void find_places(const Window& window, const Particles& p, const std::vector<int>& who, Places& places);

}  // namespace twogrid
