// Planes in the fluid's grid: open shares, links and friction against formulas.
// What would pass falsely without it: a cut area or volume that is nearly right; walls whose areas don't close the cells
// they cut; friction that leaves a net force on fluid that shears along a plane wall, or fluid that follows its neighbours
// too fast.
#include <gtest/gtest.h>

#include <random>

#include "tests/unit/cfd/cut_scene.h"

namespace twogrid {
namespace {

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

/// Mean of sum of m x - s over the part of the unit square where it is above 0.
double mean_above(const std::vector<double>& m, double s) {
  std::vector<double> positive;
  double rest = s, sum = -s, product = 1;
  for (double q : m) {
    sum += 0.5 * q;
    if (q < 0) rest -= q;
    if (std::abs(q) >= 1e-9) positive.push_back(std::abs(q)), product *= std::abs(q);
  }
  const int n = int(positive.size());
  double below = 0, faculty = 1;
  for (unsigned set = 0; set < 1u << n; ++set) {
    double left = rest;
    for (int q = 0; q < n; ++q) left -= set >> q & 1 ? positive[q] : 0;
    below += (__builtin_popcount(set) % 2 ? -1 : 1) * std::pow(std::max(left, 0.0), n + 1);
  }
  for (int q = 2; q <= n + 1; ++q) faculty *= q;
  return (sum + below / (faculty * product)) / share_above(m, s);
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
    CutScene cut(kGraded, {false, false, false}, {body_of<PlaneShape>(p[0], p[1])});
    cut.run();
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

/// u = height over a plane wall: shear without a net force on any face in the fluid, whatever the plane's direction; and
/// slivers follow the faces beside them exactly. u = height^2/2: a force of 1 per volume.
TEST(CutGrid, ShearAlongAPlaneHasNoNetForce) {
  long long checked = 0, slivers = 0;
  double least = 1, most = 1;
  for (const auto& p : planes()) {
    CutScene cut(kGraded, {false, false, false}, {body_of<PlaneShape>(p[0], p[1])});
    cut.run();
    const double size = std::sqrt(p[1][0] * p[1][0] + p[1][1] * p[1][1] + p[1][2] * p[1][2]);
    const auto height = [&](const Vec3& x) {
      return (p[1][0] * (x[0] - p[0][0]) + p[1][1] * (x[1] - p[0][1]) + p[1][2] * (x[2] - p[0][2])) / size;
    };
    std::array<std::vector<double>, 3> alpha;
    for (int d = 0; d < 3; ++d) alpha[d] = cut.alpha(d);
    const std::vector<double> theta = cut.theta();
    // The mean height of a face's open part.
    const auto open_height = [&](int c, const Int3& f) {
      std::vector<double> m;
      double s = 0;
      for (int e = 0; e < 3; ++e) {
        s += p[1][e] * (p[0][e] - cut.grid.axis[e].node(f[e])) / size;
        if (e != c) m.push_back(p[1][e] * cut.grid.axis[e].width(f[e]) / size);
      }
      return mean_above(m, s);
    };
    double worst = 0, worst_bent = 0;
    for (const Sliver& s : cut.space.slivers) {
      bool plain = true;
      double along = 0, sum = 0;
      for (int q = 0; q < 6; ++q) {
        Int3 next = s.face;
        next[q / 2] += q % 2 ? 1 : -1;
        plain = plain && next[q / 2] > 1 && next[q / 2] < cut.grid.axis[q / 2].n() - 2;
        if (s.share[q] > 0) along += s.share[q] * open_height(s.component, next), sum += s.share[q];
      }
      const double height_here = open_height(s.component, s.face);
      if (!plain || height_here < 0.02 * 0.08 || sum == 0) continue;
      ++slivers;
      worst = std::max(worst, std::abs(along / height_here - 1));
    }
    for (int c = 0; c < 3; ++c) {
      const std::vector<double> bits = cut.links(c), friction = cut.conductance(c),
                                at_centre = cut.gathered(cut.faces(c), cut.space.centre[c]),
                                factor = cut.gathered(cut.faces(c), cut.space.viscous[c]);
      Box inner = cut.grid.cells();
      for (int d = 0; d < 3; ++d) inner.lo[d] += d == c ? 2 : 1, inner.hi[d] -= d == c ? 2 : 1;
      for_each(inner, [&](int i, int j, int k) {
        const Int3 f{i, j, k};
        const unsigned b = unsigned(bits[cut.at(f)]);
        if (!(alpha[c][cut.at(f)] > 0) || b & OpenSpace::kSliver) return;
        const double u = height(cut.face(c, f));
        const double open_u = open_height(c, f);
        const double s = factor[cut.at(f)];
        double net = -friction[cut.at(f)] * open_u, bent = -friction[cut.at(f)] * open_u * u / 2, scale = 0, volume = 0;
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
            const double w = height(y);
            if (b >> (2 * d + up) & 1) {
              net += s * area * (w - u) / std::abs(y[d] - x[d]);
              bent += s * area * (w * w - u * u) / 2 / std::abs(y[d] - x[d]);
            }
          }
        for (int below = 0; below < 2; ++below) {
          Int3 q = f;
          q[c] -= below;
          volume += 0.5 * theta[cut.at(q)] * cut.grid.volume(q[0], q[1], q[2]);
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
        worst = std::max(worst, std::abs(at_centre[cut.at(f)] * open_u / u - 1));
        if (s != 1)
          worst_bent = std::max(worst_bent, std::abs(bent / volume - 1)), least = std::min(least, s),
          most = std::max(most, s);
      });
    }
    EXPECT_LT(worst_bent, 1e-9) << p[1][0] << " " << p[1][1] << " " << p[1][2];
    // Corners within 2e-4 of an edge from the plane count as on it (LocalGrid::kOn): what they would cut off is missing.
    EXPECT_LT(worst, 1e-8) << p[1][0] << " " << p[1][1] << " " << p[1][2];
  }
  MPI_Allreduce(MPI_IN_PLACE, &slivers, 1, MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_GT(checked, 1000);
  EXPECT_GT(most, 1.2);
  if (rank_of(MPI_COMM_WORLD) == 0) std::printf("viscous forces beside planes times %.3f to %.3f\n", least, most);
  EXPECT_GT(slivers, 100);
}

}  // namespace twogrid
