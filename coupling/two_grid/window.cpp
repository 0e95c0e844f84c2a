#include "coupling/two_grid/window.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "cfd/parallel/ranks.h"
#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

namespace {

/// Node that holds x, images of a periodic direction included; a side that is not periodic gives -1 or n.
int find_image(const Axis& a, double x) {
  if (!a.periodic()) return a.find(x);
  const int image = int(std::floor((x - a.lo()) / a.length()));
  return std::clamp(a.find(x - image * a.length()), 0, a.n() - 1) + image * a.n();
}

/// Low side of node i, images included.
double node_image(const Axis& a, int i) {
  const int image = int(std::floor(double(i) / a.n()));
  return a.node(i - image * a.n()) + image * a.length();
}

/// Integral of the quadratic B-spline from minus infinity to s, s in thirds of its full width.
double spline_integral(double s) {
  if (s <= -1.5) return 0;
  if (s >= 1.5) return 1;
  if (s < -0.5) return (s + 1.5) * (s + 1.5) * (s + 1.5) / 6;
  if (s > 0.5) return 1 - (1.5 - s) * (1.5 - s) * (1.5 - s) / 6;
  return 0.5 + s * (0.75 - s * s / 3);
}

void linear_weights(const Window::Span& a, double x, int& lo, int& n, double* w) {
  a.between(x, lo, w[1]);
  lo += a.lo;
  n = a.hi - a.lo > 1 ? 2 : 1;
  w[0] = 1 - w[1];
}

void kernel_weights(const Window::Span& a, double x, double width, int& lo, int& n, double* w) {
  if (!a.periodic) x = std::clamp(x, a.domain_lo, a.domain_hi);
  lo = a.find(x - 0.5 * width);
  const int last = a.find(x + 0.5 * width);
  n = last - lo + 1;
  const double scale = 3 / width;
  const double first = spline_integral((a.low(lo) - x) * scale);
  double left = first;
  for (int i = 0; i < n; ++i) {
    const double right = spline_integral((a.high(lo + i) - x) * scale);
    w[i] = right - left;
    left = right;
  }
  const double inverse = 1 / (left - first);
  for (int i = 0; i < n; ++i) w[i] *= inverse;
}

void cube_weights(const Window::Span& a, double x, double edge, int& lo, int& n, double* w) {
  double left = x - 0.5 * edge, right = x + 0.5 * edge;
  if (!a.periodic) {
    if (left < a.domain_lo) left = a.domain_lo, right = std::min(left + edge, a.domain_hi);
    if (right > a.domain_hi) right = a.domain_hi, left = std::max(right - edge, a.domain_lo);
  }
  lo = a.find(left);
  const int last = std::max(lo, a.find(right));
  n = last - lo + 1;
  const double inverse = 1 / (right - left);
  for (int i = 0; i < n; ++i)
    w[i] = std::max(0.0, std::min(right, a.high(lo + i)) - std::max(left, a.low(lo + i))) * inverse;
}

}  // namespace

int Window::Span::find_stretched(double x) const {
  const int n = hi - lo;
  return std::clamp(int(std::upper_bound(node.begin(), node.end(), x) - node.begin()) - 1, 0, n - 1) + lo;
}

void Window::Span::between_stretched(double x, int& lower, double& w) const {
  const int n = int(centre.size());
  const int above = int(std::upper_bound(centre.begin(), centre.end(), x) - centre.begin());
  lower = std::clamp(above - 1, 0, std::max(n - 2, 0));
  w = n > 1 ? std::clamp((x - centre[lower]) / (centre[lower + 1] - centre[lower]), 0.0, 1.0) : 0.0;
}

Window::Window(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const ParticleRegion& region,
               Spread spread, double width)
    : spread_(spread), width_(width) {
  const OpenNodes* const open = grid.open_nodes();
  if (open) cut_ = true, search_ = open->search();
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    Span& s = span_[d];
    // A cube shifted inside at a wall reaches its whole edge inwards; one node more all around covers the pair of
    // linear weights and rounding of the coordinates.
    const double margin = region.reach + (spread == Spread::kCube ? width : 0.5 * width);
    s.lo = find_image(a, region.lo[d] - margin) - 2 - search_[d];
    s.hi = find_image(a, region.hi[d] + margin) + 3 + search_[d];
    if (!a.periodic()) {
      s.lo = std::clamp(s.lo, 0, a.n() - 1);
      s.hi = std::clamp(s.hi, s.lo + 1, a.n());
    }
    for (int i = s.lo; i <= s.hi; ++i) s.node.push_back(node_image(a, i));
    for (int i = 0; i < s.hi - s.lo; ++i) s.centre.push_back(0.5 * (s.node[i] + s.node[i + 1]));
    if (!a.periodic() && s.hi == a.n()) s.node.back() = a.hi();
    // Nodes before the first that have a place, on any rank: with few nodes around a period the window goes further
    // back.
    const int further = (search_[d] + a.n() - 1) / a.n() * a.n();
    const int before = !a.periodic() ? 0 : (a.n() < 4 ? 4 * a.n() : a.n()) + further;
    s.pair_origin = a.lo() + (0.5 - before) * (a.length() / a.n());
    s.per_gap = a.n() / a.length();
    s.first_pair = s.lo + before, s.end_pair = s.hi - 1 + before;
    s.last_pair = std::max(s.end_pair - 1, s.first_pair);
    s.edge = s.node;
    s.edge.front() = -HUGE_VAL, s.edge.back() = NAN;
    s.domain_lo = a.lo(), s.domain_hi = a.hi();
    const double slack = 1e-6 * a.length() / a.n();
    s.x_lo = region.lo[d] - region.reach - slack, s.x_hi = region.hi[d] + region.reach + slack;
    s.periodic = a.periodic(), s.uniform = a.uniform();
    s.inverse_width = (s.hi - s.lo) / (s.node.back() - s.node.front());
    box_.lo[d] = s.lo, box_.hi[d] = s.hi;
    double narrowest = a.width(0);
    for (int i = 1; i < a.n(); ++i) narrowest = std::min(narrowest, a.width(i));
    if (width / narrowest + 2 > Stencil::kMax)
      throw std::invalid_argument("a width of " + std::to_string(width) + " m spans " +
                                  std::to_string(int(width / narrowest)) + " cells in direction " + "xyz"[d] +
                                  ", at most " + std::to_string(Stencil::kMax - 2) +
                                  " are served: reduce the width of deposit or read, or the number of cells");
  }
  const int ranks = ranks_of(comm);
  const int mine[6] = {box_.lo[0], box_.lo[1], box_.lo[2], box_.hi[0], box_.hi[1], box_.hi[2]};
  std::vector<int> all(6 * ranks);
  MPI_Allgather(mine, 6, MPI_INT, all.data(), 6, MPI_INT, comm);
  std::vector<Box> wanted(ranks);
  for (int r = 0; r < ranks; ++r)
    for (int d = 0; d < 3; ++d) wanted[r].lo[d] = all[6 * r + d], wanted[r].hi[d] = all[6 * r + 3 + d];
  exchange_ = BlockExchange(comm, nodes.all_cells(), wanted, grid.n(), grid.periodic());
  if (open) take_sight(*open);
}

void Window::take_sight(const OpenNodes& nodes) {
  Array3<long long> sight(box_);
  bring<long long>({&nodes.sight()}, {&sight});
  sight_.assign(sight.data(), sight.data() + sight.size());
}

bool Window::is_open(std::ptrdiff_t place) const {
  return (sight_[place] & OpenNodes::kOpen) != 0;
}

std::ptrdiff_t Window::nearest_open(const double x[3], std::ptrdiff_t own) const {
  Int3 home, lo, hi;
  for (int d = 0; d < 3; ++d) {
    home[d] = span_[d].find(x[d]);
    lo[d] = std::max(home[d] - search_[d], box_.lo[d]), hi[d] = std::min(home[d] + search_[d] + 1, box_.hi[d]);
  }
  const auto distance = [&](int d, int i) {
    const double beyond = std::max(span_[d].low(i) - x[d], x[d] - span_[d].high(i));
    return i == home[d] || !(beyond > 0) ? 0.0 : beyond * beyond;
  };
  double least = HUGE_VAL;
  std::ptrdiff_t best = own;
  for (int k = lo[2]; k < hi[2]; ++k)
    for (int j = lo[1]; j < hi[1]; ++j)
      for (int i = lo[0]; i < hi[0]; ++i) {
        const std::ptrdiff_t m = place(i - box_.lo[0], j - box_.lo[1], k - box_.lo[2]);
        if (!is_open(m)) continue;
        const double away = distance(0, i) + distance(1, j) + distance(2, k);
        if (away < least) least = away, best = m;
      }
  return best;
}

void Window::see_corners(const double x[3], SeenNodes& s) const {
  const Corners c = corners(x);
  const WindowShape shape = this->shape();
  s.n = 8;
  s.at.resize(8), s.w.resize(8);
  s.home = is_open(c.home) ? c.home : nearest_open(x, node(x));
  const std::uint32_t sight = s.home == c.home ? sight_[c.home] : 0;
  Int3 upper;  // which of the eight is home
  std::ptrdiff_t rest = c.home - c.at;
  for (int d = 2; d >= 0; --d) {
    upper[d] = shape.up[d] > 0 && rest >= shape.up[d];
    rest -= upper[d] * shape.up[d];
  }
  for (int q = 0; q < 8; ++q) {
    const Int3 corner{q & 1, q >> 1 & 1, q >> 2};
    Int3 offset;
    double w = 1;
    std::ptrdiff_t m = c.at;
    for (int d = 0; d < 3; ++d) {
      w *= corner[d] ? c.w[d] : 1 - c.w[d];
      m += corner[d] * shape.up[d];
      offset[d] = shape.up[d] > 0 ? corner[d] - upper[d] : 0;
    }
    s.w[q] = w;
    s.at[q] = sight & OpenNodes::seen(offset[0], offset[1], offset[2]) ? m : s.home;
  }
}

void Window::see(const double x[3], SeenNodes& s) const {
  if (spread_ == Spread::kLinear) {
    see_corners(x, s);
    return;
  }
  weights(x, s.all);
  const Stencil& all = s.all;
  const std::ptrdiff_t own = shape().place(all.home);
  s.home = own;
  if (!is_open(own)) {
    s.home = nearest_open(x, own);
    s.n = 1;
    s.at.assign(1, s.home), s.w.assign(1, 1.0);
    return;
  }
  seen_from(all.home, all.lo, all.n, s.at);
  s.n = int(s.at.size());
  s.w.resize(s.n);
  double* w = s.w.data();
  for (int k = 0; k < all.n[2]; ++k)
    for (int j = 0; j < all.n[1]; ++j) {
      const double wjk = all.w[1][j] * all.w[2][k];
      for (int i = 0; i < all.n[0]; ++i) *w++ = all.w[0][i] * wjk;
    }
}

void Window::seen_from(const Int3& home, const Int3& lo, const Int3& n, std::vector<std::ptrdiff_t>& at) const {
  const WindowShape shape = this->shape();
  const std::ptrdiff_t own = shape.place(home);
  const std::size_t count = std::size_t(n[0]) * n[1] * n[2];
  at.assign(count, own);
  const Box box{lo, {lo[0] + n[0], lo[1] + n[1], lo[2] + n[2]}};
  bool near = true;
  for (int d = 0; d < 3; ++d) near = near && box.lo[d] >= home[d] - 1 && box.hi[d] <= home[d] + 2;
  const auto sees = [&](const Int3& from, int x, int y, int z) {
    return (sight_[shape.place(from)] & OpenNodes::seen(x, y, z)) != 0;
  };
  if (near) {
    std::size_t q = 0;
    for_each(box, [&](int i, int j, int k) {
      if (sees(home, i - home[0], j - home[1], k - home[2])) at[q] = shape.place({i, j, k});
      ++q;
    });
    return;
  }
  // Further nodes: from one to the next that it sees, within the box.
  std::vector<Int3>& frontier = frontier_;
  std::vector<char>& reached = reached_;
  reached.assign(count, 0);
  const auto reach = [&](const Int3& c) {
    const std::size_t q = (c[0] - lo[0]) + std::size_t(n[0]) * ((c[1] - lo[1]) + std::size_t(n[1]) * (c[2] - lo[2]));
    if (reached[q]) return;
    reached[q] = 1;
    at[q] = shape.place(c);
    frontier.push_back(c);
  };
  if (box.contains(home[0], home[1], home[2])) reach(home);
  while (!frontier.empty()) {
    const Int3 c = frontier.back();
    frontier.pop_back();
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
          if (box.contains(c[0] + x, c[1] + y, c[2] + z) && sees(c, x, y, z)) reach({c[0] + x, c[1] + y, c[2] + z});
  }
}

void Window::wide_weights(const double x[3], Stencil& s) const {
  for (int d = 0; d < 3; ++d) {
    const Span& a = span_[d];
    s.home[d] = a.find(x[d]);
    // Not finite: see Span::find(). Weights must be numbers all the same, since parts of sums become integers by them.
    const double at = std::isfinite(x[d]) ? x[d] : a.domain_lo;
    switch (spread_) {
      case Spread::kCell:  // see weights()
        break;
      case Spread::kLinear:
        linear_weights(a, x[d], s.lo[d], s.n[d], s.w[d]);
        break;
      case Spread::kKernel:
        kernel_weights(a, at, width_, s.lo[d], s.n[d], s.w[d]);
        break;
      case Spread::kCube:
        cube_weights(a, at, width_, s.lo[d], s.n[d], s.w[d]);
        break;
    }
  }
}

namespace {

TWOGRID_VECTORISED void find_nodes(const Window& window, const Particles& p, const std::vector<int>& who,
                                   std::ptrdiff_t* node) {
  const std::size_t n = who.size();
  if (!window.uniform()) {
    for (std::size_t q = 0; q < n; ++q) node[q] = window.node(p.x[who[q]]);
    return;
  }
  const Window::UniformCells cells = window.uniform_cells();
  std::size_t q = 0;
  for (; q + 4 <= n; q += 4) {
    const double* const x[4] = {p.x[who[q]], p.x[who[q + 1]], p.x[who[q + 2]], p.x[who[q + 3]]};
    Four at{0, 0, 0, 0};
    FourIntegers near{0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) Window::add_place(cells.d[d], Four{x[0][d], x[1][d], x[2][d], x[3][d]}, at, near);
    for (int l = 0; l < 4; ++l) node[q + l] = std::ptrdiff_t(at[l]);
    if ((near[0] | near[1] | near[2] | near[3]) != 0)
      for (int l = 0; l < 4; ++l) node[q + l] = window.node(x[l]);
  }
  for (; q < n; ++q) node[q] = window.node(p.x[who[q]]);
}

TWOGRID_VECTORISED void find_corners(const Window& window, const Particles& p, const std::vector<int>& who,
                                     Corners* corners) {
  const std::size_t n = who.size();
  if (!window.uniform()) {
    for (std::size_t q = 0; q < n; ++q) corners[q] = window.corners(p.x[who[q]]);
    return;
  }
  const Window::UniformPairs pairs = window.uniform_pairs();
  for (std::size_t q = 0; q < n; ++q) {
    Four x;
    three_at(p.x[who[q]], who[q] + 1 == p.n, x);
    Window::corners(pairs, x, corners[q]);
  }
}

}  // namespace

void find_places(const Window& window, const Particles& p, const std::vector<int>& who, Places& places) {
  if (window.spread() == Spread::kCell) {
    places.node.resize(who.size());
    find_nodes(window, p, who, places.node.data());
    if (window.cut())
      for (std::size_t q = 0; q < who.size(); ++q)
        if (!window.is_open(places.node[q])) places.node[q] = window.open_node(p.x[who[q]]);
  } else if (window.cut()) {
    places.corners.clear();
  } else if (window.spread() == Spread::kLinear) {
    places.corners.resize(who.size());
    find_corners(window, p, who, places.corners.data());
  }
}

}  // namespace twogrid
