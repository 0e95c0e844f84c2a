// Deposition of solid volume, its bound and its prolongation.
//
// Without these tests would pass: weights that lose volume at a wall, corner, periodic side or rank border (the bed
// then weighs too little, and dp is wrong by the same share); a sphere-cell volume that is right for octants and wrong
// where an edge grazes the sphere; sums that change with the number of ranks; a bound that throws volume away.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "cfd/parallel/ranks.h"
#include "coupling/particles/ledger.h"
#include "coupling/two_grid/prolongation.h"
#include "coupling/void_fraction/solid_limit.h"
#include "coupling/void_fraction/sphere_overlap.h"
#include "coupling/void_fraction/volume_deposit.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Gauss-Legendre rule on [0, 1], nodes by Newton's method on the recurrence.
struct Gauss {
  std::vector<double> x, w;
  explicit Gauss(int n) : x(n), w(n) {
    for (int i = 0; i < n; ++i) {
      double z = std::cos(kPi * (i + 0.75) / (n + 0.5)), dp = 1;
      for (int it = 0; it < 100; ++it) {
        double p0 = 1, p1 = z;
        for (int k = 2; k <= n; ++k) {
          const double p2 = ((2 * k - 1) * z * p1 - (k - 1) * p0) / k;
          p0 = p1, p1 = p2;
        }
        dp = n * (z * p1 - p0) / (z * z - 1);
        const double step = p1 / dp;
        z -= step;
        if (std::abs(step) < 1e-15) break;
      }
      x[i] = 0.5 * (1 + z);
      w[i] = 1 / ((1 - z * z) * dp * dp);
    }
  }
};

/// Integral over [lo, hi] in pieces; the substitution flattens root singularities at the pieces' ends.
template <class F>
double integrate(const Gauss& g, std::vector<double> breaks, double lo, double hi, F&& f) {
  breaks.push_back(lo);
  breaks.push_back(hi);
  std::sort(breaks.begin(), breaks.end());
  double sum = 0;
  for (std::size_t q = 0; q + 1 < breaks.size(); ++q) {
    const double a = breaks[q], b = breaks[q + 1];
    if (a < lo || b > hi || b <= a) continue;
    for (std::size_t i = 0; i < g.x.size(); ++i) {
      const double t = g.x[i], s = t * t * t * (10 + t * (6 * t - 15)), ds = 30 * t * t * (1 - t) * (1 - t);
      sum += g.w[i] * ds * (b - a) * f(a + (b - a) * s);
    }
  }
  return sum;
}

/// Volume of the unit ball with x > a, y > b, z > c, by quadrature over z and, at each z, over x: an independent path.
double beyond_by_quadrature(const Gauss& g, double a, double b, double c) {
  auto area = [&](double rho) {  // of the disc x > a, y > b
    if (rho <= 0) return 0.0;
    const double from = std::asin(std::clamp(a / rho, -1.0, 1.0));
    std::vector<double> breaks;
    if (std::abs(b) < rho) breaks = {std::acos(std::abs(b) / rho), -std::acos(std::abs(b) / rho)};
    return integrate(g, breaks, from, kPi / 2, [&](double phi) {
      const double y = rho * std::cos(phi);
      return (y - std::clamp(b, -y, y)) * y;
    });
  };
  std::vector<double> breaks{0};
  for (double r : {std::abs(a), std::abs(b), std::sqrt(a * a + b * b)})
    if (r < 1) breaks.push_back(std::acos(r)), breaks.push_back(-std::acos(r));
  const double from = std::asin(std::clamp(c, -1.0, 1.0));
  return integrate(g, breaks, from, kPi / 2, [&](double psi) { return area(std::cos(psi)) * std::cos(psi); });
}

TEST(SphereOverlap, SpecialCases) {
  EXPECT_DOUBLE_EQ(ball_beyond(-1.0), 4 * kPi / 3);
  EXPECT_DOUBLE_EQ(ball_beyond(0.0), 2 * kPi / 3);
  EXPECT_NEAR(ball_beyond(0.5), kPi / 3 * 0.25 * 2.5, 1e-15);  // cap of height 1/2
  EXPECT_NEAR(ball_beyond(0.0, 0.0), kPi / 3, 1e-15);
  EXPECT_NEAR(ball_beyond(0.0, 0.0, 0.0), kPi / 6, 1e-15);
  EXPECT_EQ(ball_beyond(0.8, 0.8), 0);
  EXPECT_EQ(ball_beyond(0.6, 0.6, 0.6), 0);
  // The cube inscribed in the ball, edge 2/sqrt(3), lies wholly inside: its volume by inclusion and exclusion.
  const double h = 1 / std::sqrt(3.0) - 1e-9;
  double cube = 0;
  for (int q = 0; q < 8; ++q)
    cube += ((q & 1) + (q >> 1 & 1) + (q >> 2 & 1)) % 2 ? -ball_beyond(q & 1 ? h : -h, q & 2 ? h : -h, q & 4 ? h : -h)
                                                        : ball_beyond(q & 1 ? h : -h, q & 2 ? h : -h, q & 4 ? h : -h);
  EXPECT_NEAR(cube, 8 * h * h * h, 1e-14);
}

TEST(SphereOverlap, AgreesWithQuadrature) {
  const Gauss g(40);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1.1, 1.1);
  double worst = 0;
  for (int t = 0; t < 150; ++t) {
    const double a = u(random), b = u(random), c = u(random);
    worst = std::max(worst, std::abs(ball_beyond(a, b, c) - beyond_by_quadrature(g, a, b, c)));
  }
  EXPECT_LT(worst, 1e-9);
}

// Where an edge or a corner just touches the sphere, arcs and angles are lost to round-off, their volume must not be.
TEST(SphereOverlap, AccurateWherePlanesGraze) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  double worst = 0;
  for (int t = 0; t < 2000; ++t) {
    double n[3], r = 0;
    for (double& x : n) x = u(random), r += x * x;
    if (t % 2) r -= n[2] * n[2];
    r = std::sqrt(r) * (1 + 1e-15 * (t % 7 - 3));
    const double a = n[0] / r, b = n[1] / r, c = t % 2 ? n[2] : n[2] / r;
    // Cutting by one more plane splits the volume into two that add up.
    worst = std::max(worst, std::abs(ball_beyond(a, b, c) + ball_beyond(a, b, -c) - ball_beyond(a, b)));
    worst = std::max(worst, std::abs(ball_beyond(a, b, c) + ball_beyond(-a, b, c) - ball_beyond(b, c)));
    // The volume is a smooth function of where the planes lie.
    const double step = 1e-9;
    worst = std::max(worst, std::abs(ball_beyond(a + step, b, c) - ball_beyond(a - step, b, c)) - 4 * kPi * step);
  }
  EXPECT_LT(worst, 2e-15);
}

// ---------------------------------------------------------------------------------------------------------------------

struct Scene {
  FineGrid grid;
  Int3 ratio;
  Bodies bodies;
  double reach;
};

/// 8 x 8 x 16 fine cells; particles at random, on faces, edges and corners of the grid, and half a skin outside.
Scene make_scene(const Int3& ratio, std::array<bool, 3> periodic, double stretch, double diameter, unsigned seed) {
  Scene s;
  s.grid = make_grid({-0.1, 0.2, 0}, {0.7, 1.0, 1.6}, {8, 8, 16}, periodic, {stretch, 1, stretch});
  s.ratio = ratio;
  s.reach = 0.03;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  auto radius = [&] { return 0.5 * diameter * (0.8 + 0.4 * u(random)); };
  auto point = [&](double fx, double fy, double fz) {
    Vec3 x;
    const double f[3] = {fx, fy, fz};
    for (int d = 0; d < 3; ++d) x[d] = s.grid.axis[d].lo() + f[d] * s.grid.axis[d].length();
    return x;
  };
  int id = 0;
  for (int q = 0; q < 60; ++q) s.bodies.add(point(u(random), u(random), u(random)), radius(), 1000, {0, 0, 0}, ++id);
  for (int q = 0; q < 40; ++q) {  // on nodes of the grid, in one, two and three directions
    Vec3 x = point(u(random), u(random), u(random));
    for (int d = 0; d < 3; ++d)
      if (d <= q % 3) x[d] = s.grid.axis[d].node(int(u(random) * (s.grid.axis[d].n() + 1)));
    s.bodies.add(x, radius(), 1000, {0, 0, 0}, ++id);
  }
  for (int q = 0; q < 27; ++q) {  // sides, edges and corners of the domain, on them and outside
    const double out = q % 2 ? s.reach : 0.0;
    Vec3 x = point(u(random), u(random), u(random));
    const int side[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 - 1};
    for (int d = 0; d < 3; ++d)
      if (side[d] != 0) x[d] = side[d] < 0 ? s.grid.axis[d].lo() - out : s.grid.axis[d].hi() + out;
    s.bodies.add(x, radius(), 1000, {0, 0, 0}, ++id);
  }
  return s;
}

struct Deposited {
  Array3<long long> solid;  // own nodes
  double volume = 0;        // of this rank's particles
  FixedPoint scale;
};

Deposited deposit(MPI_Comm comm, const Scene& s, const Bodies& all, Deposit kind, double edge) {
  Bodies mine = share_of(all, s.grid, comm);
  const ParticleGrid nodes(s.grid, s.ratio);
  const Layout layout = node_layout(make_layout(s.grid, ranks_of(comm), s.ratio), nodes);
  VolumeDeposit d(comm, nodes, layout, make_region(s.grid, comm, s.reach), kind, edge);
  double largest = 0;
  for (double r : all.radius) largest = std::max(largest, r);
  d.prepare(largest);
  Particles p = mine.view();
  std::vector<int> who(p.n);
  std::iota(who.begin(), who.end(), 0);
  Deposited out;
  out.solid.reset(layout.cells(rank_of(comm)));
  d(p, who, out.solid);
  out.scale = d.scale();
  Sum v;
  for (double r : mine.radius) v += sphere_volume(r);
  out.volume = v.value();
  return out;
}

double total(MPI_Comm comm, double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm);
  return all;
}

TEST(Deposition, AllVolumeArrivesWithTheSameBitsOnAnyRanks) {
  double worst = 0;
  long long scenes = 0;
  for (Deposit kind : {Deposit::kCentroid, Deposit::kTrilinear, Deposit::kExact, Deposit::kCube})
    for (int ratio : {1, 2, 4, 8})
      for (int sides = 0; sides < 3; ++sides)
        for (double stretch : {1.0, 1.07}) {
          // More ranks than nodes in a direction leave ranks without nodes: allowed, and met here at ratio 8.
          const std::array<bool, 3> periodic{sides == 1, sides == 1, sides >= 1};
          // From a twentieth of a node to five fine cells (0.1 m each) across.
          const double diameter = ratio == 1 ? 0.5 : ratio == 2 ? 0.25 : 0.04;
          const Scene s = make_scene({ratio, ratio, ratio}, periodic, stretch, diameter, 100 * ratio + sides);
          const double edge = ratio <= 2 ? 0.37 : 0.2;
          const Deposited d = deposit(MPI_COMM_WORLD, s, s.bodies, kind, edge);
          double sum = 0;
          for (std::size_t m = 0; m < d.solid.size(); ++m) sum += d.scale.value(d.solid.data()[m]);
          const double particles = total(MPI_COMM_WORLD, d.volume);
          const double error = std::abs(total(MPI_COMM_WORLD, sum) - particles) / particles;
          worst = std::max(worst, error);
          ++scenes;
          const std::string what = "kind " + std::to_string(int(kind)) + " ratio " + std::to_string(ratio) + " sides " +
                                   std::to_string(sides) + " stretch " + std::to_string(stretch);
          EXPECT_LE(error, 1e-13) << what;

          // The same on one rank, with the particles in another order.
          Bodies shuffled;
          std::vector<int> order(s.bodies.x.size());
          std::iota(order.begin(), order.end(), 0);
          std::shuffle(order.begin(), order.end(), std::mt19937(3));
          for (int q : order) shuffled.add(s.bodies.x[q], s.bodies.radius[q], 1000);
          const Deposited one = deposit(MPI_COMM_SELF, s, shuffled, kind, edge);
          long long differ = 0, negative = 0;
          for_each(d.solid.box(), [&](int i, int j, int k) {
            differ += d.solid(i, j, k) != one.solid(i, j, k);
            negative += d.solid(i, j, k) < 0;
          });
          EXPECT_EQ(differ, 0) << what;
          EXPECT_EQ(negative, 0) << what;
        }
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("             solid volume: largest relative error %.1e in %lld scenes\n", worst, scenes);
}

// The right volume in the right node: exact intersection against counting points, cubes against their overlap.
TEST(Deposition, ExactVolumesInEachNode) {
  Scene s = make_scene({2, 2, 2}, {false, false, true}, 1.07, 0.1, 5);
  s.bodies = Bodies();
  const double radius = 0.22;
  const Vec3 centre{0.31, 0.55, 0.03};  // across the periodic side at z = 0
  s.bodies.add(centre, radius, 1);
  const Deposited d = deposit(MPI_COMM_SELF, s, s.bodies, Deposit::kExact, 0);
  const ParticleGrid nodes(s.grid, s.ratio);
  Array3<double> counted(d.solid.box());
  // Columns along z have an exact chord, so that only x and y are sampled, node by node.
  const int n = 700;
  for_each(d.solid.box(), [&](int i, int j, int k) {
    const double x0 = std::max(nodes.axis[0].node(i), centre[0] - radius);
    const double x1 = std::min(nodes.axis[0].node(i + 1), centre[0] + radius);
    const double y0 = std::max(nodes.axis[1].node(j), centre[1] - radius);
    const double y1 = std::min(nodes.axis[1].node(j + 1), centre[1] + radius);
    if (x1 <= x0 || y1 <= y0) return;
    const double area = (x1 - x0) * (y1 - y0) / (double(n) * n);
    double sum = 0;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        const double x = x0 + (x1 - x0) * (a + 0.5) / n - centre[0], y = y0 + (y1 - y0) * (b + 0.5) / n - centre[1];
        const double h2 = radius * radius - x * x - y * y;
        if (h2 <= 0) continue;
        const double h = std::sqrt(h2);
        for (int image = -1; image <= 0; ++image) {
          const double shift = image * nodes.axis[2].length();
          const double lo = std::max(centre[2] - h, nodes.axis[2].node(k) + shift);
          const double hi = std::min(centre[2] + h, nodes.axis[2].node(k + 1) + shift);
          if (hi > lo) sum += area * (hi - lo);
        }
      }
    counted(i, j, k) = sum;
  });
  double worst = 0;
  for_each(d.solid.box(), [&](int i, int j, int k) {
    worst = std::max(worst, std::abs(d.scale.value(d.solid(i, j, k)) - counted(i, j, k)));
  });
  EXPECT_LT(worst / sphere_volume(radius), 1e-5);  // error of the sampling
}

TEST(Deposition, TrilinearKeepsTheCentreOfVolume) {
  Scene s = make_scene({2, 2, 2}, {false, false, false}, 1.07, 0.1, 5);
  s.bodies = Bodies();
  const Vec3 centre{0.33, 0.62, 0.71};
  s.bodies.add(centre, 0.02, 1);
  const Deposited d = deposit(MPI_COMM_SELF, s, s.bodies, Deposit::kTrilinear, 0);
  const ParticleGrid nodes(s.grid, s.ratio);
  Vec3 moment{0, 0, 0};
  for_each(d.solid.box(), [&](int i, int j, int k) {
    const Int3 c{i, j, k};
    for (int e = 0; e < 3; ++e) moment[e] += d.scale.value(d.solid(i, j, k)) * nodes.axis[e].centre(c[e]);
  });
  for (int e = 0; e < 3; ++e) EXPECT_NEAR(moment[e] / sphere_volume(0.02), centre[e], 1e-13);
}

// ---------------------------------------------------------------------------------------------------------------------

struct Overfull {
  FineGrid grid;
  ParticleGrid nodes;
  Layout layout;
  FixedPoint scale;
  Array3<long long> solid;
  Overfull(MPI_Comm comm, std::array<bool, 3> periodic)
      : grid(make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, periodic, {1, 1, 1.05})),
        nodes(grid, {2, 2, 2}),
        layout(node_layout(make_layout(grid, ranks_of(comm), {2, 2, 2}), nodes)),
        scale(nodes.largest_volume(), 15) {
    solid.reset(layout.cells(rank_of(comm)));
  }
  void set(const std::function<double(int, int, int)>& fraction) {
    for_each(solid.box(),
             [&](int i, int j, int k) { solid(i, j, k) = scale.quantise(fraction(i, j, k) * nodes.volume(i, j, k)); });
  }
  long long units() const {
    long long s = 0;
    for (std::size_t m = 0; m < solid.size(); ++m) s += solid.data()[m] >> 8;  // room for the sum
    return s;
  }
};

TEST(EpsBound, MovesEverythingAndFindsRoom) {
  // A block of nodes far above the bound, so that inner ones have neighbours without room.
  auto fraction = [](int i, int j, int k) {
    return i < 3 && j < 3 && k >= 2 && k < 5 ? 1.1 : 0.1 + 0.01 * (i + j + k);
  };
  const std::array<bool, 3> periodic{true, false, false};
  Overfull s(MPI_COMM_WORLD, periodic), one(MPI_COMM_SELF, periodic);
  s.set(fraction);
  one.set(fraction);
  SolidLimit limit(MPI_COMM_WORLD, s.nodes, s.layout, EpsBound::kMove, 0.35);
  SolidLimit limit_one(MPI_COMM_SELF, one.nodes, one.layout, EpsBound::kMove, 0.35);
  std::vector<long long> before(one.solid.data(), one.solid.data() + one.solid.size());
  const SolidLimit::Result r = limit(s.scale, s.solid), r1 = limit_one(one.scale, one.solid);
  EXPECT_GT(r.displaced, 0);
  EXPECT_EQ(r.unplaced, 0);
  EXPECT_EQ(r.sweeps, r1.sweeps);
  EXPECT_EQ(std::accumulate(before.begin(), before.end(), (__int128)0) -
                    std::accumulate(one.solid.data(), one.solid.data() + one.solid.size(), (__int128)0) ==
                0,
            true);
  double least = 1, excess = 0;
  for_each(one.solid.box(), [&](int i, int j, int k) {
    least = std::min(least, 1 - one.scale.value(one.solid(i, j, k)) / one.nodes.volume(i, j, k));
    excess += std::max(0.0, fraction(i, j, k) - 0.65) * one.nodes.volume(i, j, k);
  });
  EXPECT_GE(least, 0.35 - 1e-15);
  EXPECT_NEAR(r1.displaced, excess, 1e-12 * excess);
  long long differ = 0;
  for_each(s.solid.box(), [&](int i, int j, int k) { differ += s.solid(i, j, k) != one.solid(i, j, k); });
  EXPECT_EQ(differ, 0);
}

TEST(EpsBound, ClipReportsAndNoRoomIsSaid) {
  Overfull s(MPI_COMM_WORLD, {false, false, false});
  s.set([](int i, int j, int k) { return i == 1 && j == 1 && k == 3 ? 0.9 : 0.5; });
  SolidLimit clip(MPI_COMM_WORLD, s.nodes, s.layout, EpsBound::kClip, 0.4);
  EXPECT_NEAR(clip(s.scale, s.solid).displaced, 0.3 * s.nodes.volume(1, 1, 3), 1e-12);
  EXPECT_EQ(clip(s.scale, s.solid).displaced, 0);  // nothing left to do
  s.set([](int, int, int) { return 0.8; });
  SolidLimit move(MPI_COMM_WORLD, s.nodes, s.layout, EpsBound::kMove, 0.4);
  const SolidLimit::Result r = move(s.scale, s.solid);
  EXPECT_EQ(r.displaced, 0);
  EXPECT_NEAR(r.unplaced, 0.2 * 2, 1e-12);
}

TEST(Prolongation, ConservativeBoundedAndFilledBeyondTheSides) {
  for (Prolong kind : {Prolong::kConstant, Prolong::kLinear})
    for (bool periodic_z : {true, false}) {
      const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {false, false, periodic_z}, {1.1, 1, 1.05});
      const ParticleGrid nodes(grid, {4, 2, 2});
      const Layout layout = make_layout(grid, ranks_of(MPI_COMM_WORLD), {4, 2, 2});
      const int rank = rank_of(MPI_COMM_WORLD);
      const Box own_nodes = node_layout(layout, nodes).cells(rank), own = layout.cells(rank);
      CellField<ParticleGrid> node;
      CellField<FineGrid> fine;
      node.reset(own_nodes.empty() ? own_nodes : own_nodes.grown(1), -5.0);
      fine.reset(own.empty() ? own : own.grown(2), -5.0);
      auto eps = [](int i, int j, int k) {
        return std::clamp(0.65 + 0.35 * std::sin(1.0 + 2.1 * i + 0.7 * j * j + 0.9 * k), 0.35, 1.0);
      };
      for_each(own_nodes, [&](int i, int j, int k) { node(i, j, k) = eps(i, j, k); });
      const Prolongation inject(MPI_COMM_WORLD, grid, layout, nodes, kind, 0.35);
      inject(node, fine);
      double spread = 0;
      for_each(own_nodes, [&](int I, int J, int K) {
        double sum = 0;
        for_each(nodes.block(I, J, K), [&](int i, int j, int k) {
          sum += fine(i, j, k) * grid.volume(i, j, k);
          spread = std::max(spread, std::abs(fine(i, j, k) - eps(I, J, K)));
        });
        EXPECT_NEAR(sum / nodes.volume(I, J, K), eps(I, J, K), 4e-16);
      });
      for (std::size_t m = 0; m < fine.size(); ++m) {
        EXPECT_GE(fine.data()[m], 0.35 - 1e-15);
        EXPECT_LE(fine.data()[m], 1 + 1e-15);
      }
      double largest = 0;
      MPI_Allreduce(&spread, &largest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
      EXPECT_EQ(largest > 0, kind == Prolong::kLinear);
    }
}

// A profile that is linear in space comes back exactly where there are neighbours on both sides.
TEST(Prolongation, LinearProfileIsExact) {
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {false, false, false}, {1.1, 1, 1.05});
  const ParticleGrid nodes(grid, {2, 2, 2});
  const Layout layout = make_layout(grid, ranks_of(MPI_COMM_WORLD), {2, 2, 2});
  const int rank = rank_of(MPI_COMM_WORLD);
  const Box own_nodes = node_layout(layout, nodes).cells(rank), own = layout.cells(rank);
  CellField<ParticleGrid> node;
  CellField<FineGrid> fine;
  node.reset(own_nodes.empty() ? own_nodes : own_nodes.grown(1));
  fine.reset(own.empty() ? own : own.grown(2));
  auto profile = [](double x, double y, double z) { return 0.5 + 0.1 * x - 0.05 * y + 0.08 * z; };
  for_each(own_nodes, [&](int i, int j, int k) {
    node(i, j, k) = profile(nodes.axis[0].centre(i), nodes.axis[1].centre(j), nodes.axis[2].centre(k));
  });
  Prolongation(MPI_COMM_WORLD, grid, layout, nodes, Prolong::kLinear, 0.35)(node, fine);
  for_each(intersect(own, Box{{2, 2, 2}, {6, 6, 14}}), [&](int i, int j, int k) {
    EXPECT_NEAR(fine(i, j, k), profile(grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)), 1e-14);
  });
}

}  // namespace
}  // namespace twogrid_test
