// Bodies in the fluid's grid: open shares, links and friction against formulas.
// What would pass falsely without it: a cut area or volume that is nearly right; walls whose areas don't close the cells
// they cut; friction that leaves a net force on fluid that shears along a plane wall; a cylinder that is another one along
// another axis, mirrored, or on other ranks; a wall in a plane of the grid that leaks, or closes the cells beside it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "cfd/bodies/cut_grid.h"
#include "cfd/bodies/simple_shapes.h"
#include "cfd/grid/pi.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {
namespace {

struct Cut {
  FineGrid grid;
  Layout layout;
  FluidSettings settings;
  OpenSpace space;
  CutReport report;
  MPI_Comm comm;

  Cut(const std::array<std::vector<double>, 3>& nodes, const std::array<bool, 3>& periodic, std::vector<Body> bodies,
      MPI_Comm c = MPI_COMM_WORLD, std::vector<Vec3> fluid_at = {})
      : comm(c) {
    for (int d = 0; d < 3; ++d) grid.axis[d] = Axis(nodes[d], periodic[d]);
    const int ranks = ranks_of(comm);
    Int3 dims{0, 0, 0};
    for (int d = 0; d < 3; ++d)
      if (grid.axis[d].n() < 2 * ranks) dims[d] = 1;
    MPI_Dims_create(ranks, 3, dims.data());
    std::array<std::vector<int>, 3> cuts;
    for (int d = 0; d < 3; ++d) cuts[d] = cuts_even(grid.axis[d], dims[d]);
    layout = Layout(grid, cuts);
    settings.density = 1, settings.viscosity = 1e-3;
    for (int s = 0; s < 6; ++s) {
      settings.side[s].resize(1);
      settings.side[s][0].kind = periodic[s / 2] ? BoundaryKind::kPeriodic : BoundaryKind::kNoSlip;
    }
    settings.bodies = std::move(bodies);
    settings.fluid_at = std::move(fluid_at);
    run();
  }
  void run() {
    const int rank = rank_of(comm);
    space = OpenSpace();
    for (int d = 0; d < 3; ++d) space.alpha[d].reset(layout.faces(d, rank), 1.0);
    space.theta.reset(layout.cells(rank), 1.0);
    report = cut_grid(comm, grid, layout, settings, space);
  }
  Box own() const { return layout.cells(rank_of(comm)); }
  std::size_t at(const Int3& x) const {
    return std::size_t(x[0]) + (grid.n()[0] + 1) * (std::size_t(x[1]) + (grid.n()[1] + 1) * std::size_t(x[2]));
  }
  std::vector<double> none() const {
    return std::vector<double>(std::size_t(grid.n()[0] + 1) * (grid.n()[1] + 1) * (grid.n()[2] + 1), 0.0);
  }
  template <class A>
  std::vector<double> gathered(const Box& box, const A& array) const {
    std::vector<double> all = none();
    for_each(box, [&](int i, int j, int k) { all[at({i, j, k})] = array(i, j, k); });
    return added(all);
  }
  std::vector<double> added(std::vector<double> all) const {
    MPI_Allreduce(MPI_IN_PLACE, all.data(), int(all.size()), MPI_DOUBLE, MPI_SUM, comm);
    return all;
  }
  std::vector<double> alpha(int d) const { return gathered(layout.faces(d, rank_of(comm)), space.alpha[d]); }
  std::vector<double> links(int d) const { return gathered(layout.faces(d, rank_of(comm)), space.links[d]); }
  std::vector<double> friction(int d) const { return gathered(layout.faces(d, rank_of(comm)), space.friction[d]); }
  std::vector<double> theta() const { return gathered(own(), space.theta); }
  /// Sum of the pieces' conductances of every face.
  std::vector<double> conductance(int c) const {
    std::vector<double> all = none();
    for (const WallPiece& p : space.pieces)
      if (p.component == c) all[at(p.face)] += p.conductance;
    return added(all);
  }
  Vec3 face(int d, const Int3& f) const {
    Vec3 x;
    for (int e = 0; e < 3; ++e) x[e] = e == d ? grid.axis[e].node(f[e]) : grid.axis[e].centre(f[e]);
    return x;
  }
};

Body body(std::shared_ptr<const SolidShape> shape) {
  return {"wall", std::move(shape), false};
}
template <class S, class... A>
Body body_of(A&&... a) {
  return body(std::make_shared<S>(std::forward<A>(a)...));
}

/// Share of the unit square (n = 2) or cube (n = 3) where sum of m x > s: by the formula for cut corners.
double share_above(std::vector<double> m, double s) {
  for (double& q : m)
    if (q < 0) s -= q, q = -q;
  // Directions along which nothing varies drop out.
  m.erase(std::remove_if(m.begin(), m.end(), [](double q) { return q < 1e-9; }), m.end());
  const int n = int(m.size());
  if (n == 0) return s < 0 ? 1 : 0;
  double below = 0, scale = 1;
  for (unsigned set = 0; set < 1u << n; ++set) {
    double rest = s;
    for (int q = 0; q < n; ++q) rest -= set >> q & 1 ? m[q] : 0;
    below += (__builtin_popcount(set) % 2 ? -1 : 1) * std::pow(std::max(rest, 0.0), n);
  }
  for (int q = 0; q < n; ++q) scale *= m[q] * (q + 1);
  return 1 - below / scale;
}

/// Planes in a graded grid, of some directions, along the axes and 45 degrees among them.
std::vector<std::array<Vec3, 2>> planes() {
  std::vector<std::array<Vec3, 2>> list;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int q = 0; q < 12; ++q)
    list.push_back({Vec3{0.5 + 0.1 * any(random), 0.5 + 0.1 * any(random), 0.5 + 0.1 * any(random)},
                    Vec3{any(random), any(random), any(random)}});
  for (int d = 0; d < 3; ++d)
    for (double sign : {-1.0, 1.0}) {
      Vec3 n{0, 0, 0};
      n[d] = sign;
      list.push_back({Vec3{0.4812, 0.5217, 0.4721}, n});
      n[(d + 1) % 3] = 1;
      list.push_back({Vec3{0.4812, 0.5217, 0.4721}, n});
    }
  return list;
}

const std::array<std::vector<double>, 3> kGraded{graded_nodes(0, 1, 11, 1.1), graded_nodes(0, 1.1, 9, 0.93),
                                                 graded_nodes(0, 0.9, 10)};

}  // namespace

TEST(CutGrid, PlanesAreExact) {
  for (const auto& p : planes()) {
    const Cut cut(kGraded, {false, false, false}, {body_of<PlaneShape>(p[0], p[1])});
    double worst = 0;
    const auto share = [&](const Int3& x, int normal) {
      std::vector<double> m;
      double s = 0;
      for (int d = 0; d < 3; ++d) {
        const Axis& a = cut.grid.axis[d];
        s += p[1][d] * (p[0][d] - a.node(x[d]));
        if (d != normal) m.push_back(p[1][d] * a.width(x[d]));
      }
      return share_above(m, s);
    };
    // Sides are looked at a little inside; there the cut is as exact as that.
    const auto inside = [&](const Int3& x, bool face, int normal) {
      bool in = true;
      for (int d = 0; d < 3; ++d)
        in =
            in && x[d] > 0 && (x[d] < cut.grid.axis[d].n() - 1 || (face && d == normal && x[d] < cut.grid.axis[d].n()));
      return in;
    };
    for (int d = 0; d < 3; ++d)
      for_each(cut.layout.faces(d, rank_of(MPI_COMM_WORLD)), [&](int i, int j, int k) {
        double wanted = share({i, j, k}, d);
        const double a = cut.space.alpha[d](i, j, k);
        if (wanted < 1.001e-3 && a == 0) wanted = 0;
        worst = std::max(worst, std::abs(a - wanted) * (inside({i, j, k}, true, d) ? 1 : 1e-8));
      });
    for_each(cut.own(), [&](int i, int j, int k) {
      double wanted = share({i, j, k}, -1);
      const double t = cut.space.theta(i, j, k);
      if (wanted < 1e-3 && t == 0) wanted = 0;
      worst = std::max(worst, std::abs(t - wanted) * (inside({i, j, k}, false, 0) ? 1 : 1e-8));
    });
    // Areas of the wall: along the normal, and with its size.
    const double size = std::sqrt(p[1][0] * p[1][0] + p[1][1] * p[1][1] + p[1][2] * p[1][2]);
    for (const WallCell& w : cut.space.surface) {
      bool plain = inside(w.cell, false, 0);
      for (int d = 0; d < 3; ++d)
        for (int up = 0; up < 2; ++up) {
          Int3 f = w.cell;
          f[d] += up;
          const double a = share(f, d);
          plain = plain && (a == 0 || a > 1.01e-3);
        }
      if (!plain) continue;
      const double area = std::sqrt(w.area[0] * w.area[0] + w.area[1] * w.area[1] + w.area[2] * w.area[2]);
      for (int d = 0; d < 3; ++d) worst = std::max(worst, std::abs(w.area[d] / area - p[1][d] / size) * area / 0.01);
    }
    // A vertex within 1e-4 of a cell of the plane counts as on it.
    bool near = false;
    for_each({{0, 0, 0}, {12, 10, 11}}, [&](int i, int j, int k) {
      double s = 0, width = 0;
      for (int d = 0; d < 3; ++d) {
        s += p[1][d] * (cut.grid.axis[d].node(Int3{i, j, k}[d]) - p[0][d]);
        width = std::max(width, cut.grid.axis[d].width(std::min(Int3{i, j, k}[d], cut.grid.axis[d].n() - 1)));
      }
      near = near || std::abs(s) / size < 1e-4 * width;
    });
    EXPECT_LT(worst, near ? 1e-8 : 2e-12) << p[1][0] << " " << p[1][1] << " " << p[1][2];
  }
}

/// u = height over a plane wall: shear without a net force on any face in the fluid, whatever the plane's direction.
TEST(CutGrid, ShearAlongAPlaneHasNoNetForce) {
  long long checked = 0;
  for (const auto& p : planes()) {
    const Cut cut(kGraded, {false, false, false}, {body_of<PlaneShape>(p[0], p[1])});
    const double size = std::sqrt(p[1][0] * p[1][0] + p[1][1] * p[1][1] + p[1][2] * p[1][2]);
    const auto height = [&](const Vec3& x) {
      return (p[1][0] * (x[0] - p[0][0]) + p[1][1] * (x[1] - p[0][1]) + p[1][2] * (x[2] - p[0][2])) / size;
    };
    std::array<std::vector<double>, 3> alpha;
    for (int d = 0; d < 3; ++d) alpha[d] = cut.alpha(d);
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
      const std::vector<double> bits = cut.links(c), friction = cut.conductance(c);
      Box inner = cut.grid.cells();
      for (int d = 0; d < 3; ++d) inner.lo[d] += d == c ? 2 : 1, inner.hi[d] -= d == c ? 2 : 1;
      for_each(inner, [&](int i, int j, int k) {
        const Int3 f{i, j, k};
        const unsigned b = unsigned(bits[cut.at(f)]);
        if (!(alpha[c][cut.at(f)] > 0) || b & OpenSpace::kSliver) return;
        const double u = height(cut.face(c, f));
        double net = -friction[cut.at(f)] * u, scale = 0;
        bool closed_sliver = false;  // of these the areas were dropped
        for (int d = 0; d < 3; ++d)
          for (int up = 0; up < 2; ++up) {
            Int3 g = f;
            g[d] += up ? 1 : -1;
            double area = 0;
            if (d == c) {
              area = 0.5 * (alpha[c][cut.at(f)] + alpha[c][cut.at(g)]) * cut.grid.area(c, i, j, k);
            } else {
              for (int below = 0; below < 2; ++below) {
                Int3 q = f;
                q[c] -= below, q[d] += up;
                area += 0.5 * alpha[d][cut.at(q)] * cut.grid.area(d, q[0], q[1], q[2]);
              }
            }
            const Vec3 x = cut.face(c, f), y = cut.face(c, g);
            scale += area;
            if (b >> (2 * d + up) & 1) net += area * (height(y) - u) / std::abs(y[d] - x[d]);
          }
        for (int below = 0; below < 2; ++below) {
          Int3 q = f;
          q[c] -= below;
          for (int d = 0; d < 3; ++d)
            for (int up = 0; up < 2; ++up) {
              Int3 g = q;
              g[d] += up;
              std::vector<double> m;
              double s = 0;
              for (int e = 0; e < 3; ++e) {
                s += p[1][e] * (p[0][e] - cut.grid.axis[e].node(g[e]));
                if (e != d) m.push_back(p[1][e] * cut.grid.axis[e].width(g[e]));
              }
              const double a = share_above(m, s);
              closed_sliver = closed_sliver || (a > 0 && a < 1.001e-3);
            }
        }
        if (closed_sliver || u < 0.02 * 0.08) return;  // nearer than the least distance
        ++checked;
        worst = std::max(worst, std::abs(net) / scale);
      });
    }
    EXPECT_LT(worst, 1e-11) << p[1][0] << " " << p[1][1] << " " << p[1][2];
  }
  EXPECT_GT(checked, 1000);
}

}  // namespace twogrid
