// The particle grid where bodies stand: families of nodes, sight between nodes, deposit, prolongation, reading and
// reaction.
//
// Without these tests would pass: grains against a curved wall that seem packed denser than spheres can be, because the
// node that counts them is a sliver; grains that displace, push or feel gas on the other side of a wall; solids or
// momentum that get lost in a closed node; a reaction that goes elsewhere than where was read; families that hang on
// where the ranks' borders lie.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>

#include "cfd/parallel/ranks.h"
#include "coupling/coupling.h"
#include "coupling/two_grid/open_nodes.h"
#include "coupling/two_grid/prolongation.h"
#include "coupling/two_grid/reader.h"
#include "coupling/void_fraction/volume_deposit.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A number in [0,1) that hangs on the place alone.
double number(const Vec3& x, int salt) {
  std::uint64_t h = std::uint64_t(salt + 1) * 0x9E3779B97F4A7C15ull;
  for (int d = 0; d < 3; ++d) {
    h ^= std::uint64_t(std::llround(x[d] * 1e4) + 1000) * 0xC2B2AE3D27D4EB4Full;
    h ^= h >> 31, h *= 0xBF58476D1CE4E5B9ull, h ^= h >> 29;
  }
  return double(h >> 11) * 0x1p-53;
}

/// Theta of a cell by its centre; alpha of a face that has open cells on both sides, by direction and its centre.
struct Shares {
  std::function<double(const Vec3&)> theta;
  std::function<double(int, const Vec3&)> alpha;
};

void cut(FakeFluid& fluid, const Shares& shares) {
  const FineGrid& grid = fluid.grid();
  fluid.cut(
      [&](int d, const Vec3& x) {
        const Axis& a = grid.axis[d];
        int f = 0;
        while (f < a.n() && std::abs(a.node(f) - x[d]) > 1e-6) ++f;
        for (int c : {f - 1, f}) {
          if (!a.periodic() && (c < 0 || c >= a.n())) continue;
          Vec3 cell = x;
          cell[d] = a.centre((c + a.n()) % a.n());
          if (shares.theta(cell) == 0) return 0.0;
        }
        return shares.alpha(d, x);
      },
      shares.theta);
}

/// Of a fluid that is where `open` says, by 8 points a direction; h: width of a cell.
Shares sampled(std::function<bool(const Vec3&)> open, const Vec3& h) {
  const auto mean = [=](const Vec3& x, int across) {
    constexpr int n = 8;
    int hits = 0, all = 0;
    for (int c = 0; c < n; ++c)
      for (int b = 0; b < n; ++b)
        for (int a = 0; a < n; ++a) {
          const Int3 q{a, b, c};
          if (across >= 0 && q[across] > 0) continue;
          Vec3 y = x;
          for (int d = 0; d < 3; ++d)
            if (d != across) y[d] += ((q[d] + 0.5) / n - 0.5) * h[d];
          hits += open(y), ++all;
        }
    return double(hits) / all;
  };
  return {[=](const Vec3& x) { return mean(x, -1); }, [=](int d, const Vec3& x) { return mean(x, d); }};
}
/// Whole cells are closed.
Shares blocks(std::function<bool(const Vec3&)> closed) {
  return {[=](const Vec3& x) { return closed(x) ? 0.0 : 1.0; }, [](int, const Vec3&) { return 1.0; }};
}
/// A round vessel along z, off the middle.
bool in_vessel(const Vec3& x) {
  return std::hypot(x[0] - 0.53, x[1] - 0.48) < 0.44;
}
/// Small, large and closed shares side by side, every 11th face closed.
Shares at_random() {
  return {[](const Vec3& x) {
            const double r = number(x, 7);
            return r < 0.12 ? 0.0 : 0.02 + 0.98 * number(x, 8);
          },
          [](int d, const Vec3& x) {
            const double r = number(x, d);
            return r < 1.0 / 11 ? 0.0 : 0.05 + 0.95 * r;
          }};
}

enum Body { kVessel, kRandom, kThickWall, kThinWall, kBodies };

/// Cells 3 and 4 of 8, in two nodes; or cell 3 alone.
double wall_end(Body body) {
  return body == kThickWall ? 0.625 : 0.5;
}
Shares shares_of(Body body) {
  switch (body) {
    case kVessel:
      return sampled(in_vessel, {0.125, 0.125, 0.125});
    case kRandom:
      return at_random();
    default:
      return blocks([=](const Vec3& x) { return x[0] > 0.375 && x[0] < wall_end(body); });
  }
}

/// A coupling in a closed box of 8 x 8 x 16 cells, nodes of 2 x 2 x 2.
struct Vessel {
  MPI_Comm comm;
  FineGrid grid;
  FakeFluid fluid;
  Settings settings;
  Bodies bodies;
  std::unique_ptr<Coupling> coupling;

  explicit Vessel(MPI_Comm comm, int ratio = 2)
      : comm(comm),
        grid(make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {false, false, false})),
        fluid(comm, grid, make_layout(grid, ranks_of(comm), {ratio, ratio, ratio}), 1.2, 1e-2) {
    settings.id = "gas";
    settings.ratio = {ratio, ratio, ratio};
    settings.fine = {8, 8, 16};
    settings.kernel_width = 0.3;
    settings.cube_edge = 0.25;
  }
  void add(const Vec3& x, const Vec3& v, int tag, double radius) {
    Bodies one;
    one.add(x, radius, 1000, v, tag);
    const Bodies mine = share_of(one, grid, comm);
    if (mine.x.size() == 1) bodies.add(x, radius, 1000, v, tag);
  }
  void remove(int tag) {
    Bodies kept;
    for (std::size_t q = 0; q < bodies.x.size(); ++q)
      if (bodies.tag[q] != tag) {
        kept.add(bodies.x[q], bodies.radius[q], 1000, bodies.v[q], bodies.tag[q]);
        kept.state.back() = bodies.state[q], kept.step.back() = bodies.step[q];
      }
    bodies = kept;
  }
  /// The same velocity on all faces that are solved for.
  void flow(const Vec3& u) {
    for (int d = 0; d < 3; ++d)
      for_each(fluid.u_[d].box(), [&](int i, int j, int k) {
        fluid.u_[d](i, j, k) = fluid.mean_[d](i, j, k) = fluid.state_[d](i, j, k) == FaceState::kSolved ? u[d] : 0.0;
      });
  }
  void begin() {
    const ParticleRegion r = make_region(grid, comm, 0.02);
    coupling = std::make_unique<Coupling>(comm, settings, fluid, r.lo, r.hi, r.reach);
    Particles p = bodies.view();
    coupling->start(p, 1e-3);
    coupling->force(p, 1e-3, false);
  }
  void advance(int steps) {
    Particles p = bodies.view();
    for (int s = 0; s < steps; ++s) {
      for (auto& f : bodies.f) f = {0, 0, 0};
      if (s == steps - 1) coupling->advance(p, steps, 1e-3);
      coupling->force(p, 1e-3, true);
    }
  }
};

struct Result {
  std::vector<double> eps, state, source;  // of all cells, particles and faces
  double volume_error = 0, momentum_error = 0, read_error = 0;
  long long particles = 0;
};

constexpr int kGrains = 60;
const Vec3 kFlow{1.5, -0.5, 2.5};

/// Four intervals; one grain comes, another goes, a third is deleted between two runs.
Result run(MPI_Comm comm, Body body, Deposit deposit, Read read, Formulation form) {
  Vessel s(comm);
  cut(s.fluid, shares_of(body));
  s.settings.deposit = deposit, s.settings.read = read, s.settings.formulation = form;
  s.settings.prolong = form == Formulation::kA ? Prolong::kLinear : Prolong::kConstant;
  s.settings.hold_flux = form == Formulation::kA ? Choice::kOn : Choice::kOff;
  s.flow(kFlow);
  for (int q = 0; q < kGrains; ++q) {
    Vec3 x{0.5 + 0.5 * std::sin(1.0 + q), 0.5 + 0.49 * std::cos(2.3 * q), 1 + 0.98 * std::sin(0.7 * q)};
    if (body == kVessel && q % 3) {  // against the wall, and centres a little behind it
      const double r = q % 3 == 1 ? 0.41 : 0.45;
      x[0] = 0.53 + r * std::cos(0.9 * q), x[1] = 0.48 + r * std::sin(0.9 * q);
    }
    s.add(x, {0.1 * (q % 7), -0.2, 0.3}, q + 1, 0.02 + 0.02 * (q % 2));
  }
  Result result;
  result.source.assign(3 * 9 * 9 * 17, 0.0);
  s.fluid.on_advance = [&](double, const VoidFractionInTime&, const Interphase& x) {
    for (int d = 0; d < 3; ++d) {
      const Array3<double> f = source_of(x, d, s.fluid.own_faces_[d]);
      for_each(f.box(), [&](int i, int j, int k) { result.source[d + 3 * (i + 9 * (j + 9 * k))] = f(i, j, k); });
    }
  };
  s.begin();
  const auto note = [&] {
    result.volume_error = std::max(result.volume_error, s.coupling->report().solid_volume_error);
    result.momentum_error = std::max(result.momentum_error, s.coupling->report().momentum_error);
    for (const auto& state : s.bodies.state)
      for (int d = 0; d < 3; ++d)
        result.read_error = std::max(result.read_error, std::abs(state[kFluidVelocity + d] - kFlow[d]));
  };
  note();
  s.advance(4), note();
  s.add({0.25, 0.26, 0.3}, {0, 0, 0}, kGrains + 1, 0.03);
  s.advance(4), note();
  s.remove(5);
  s.advance(4), note();
  {  // a command between two runs
    Particles p = s.bodies.view();
    s.coupling->rest(p);
    s.remove(8);
    p = s.bodies.view();
    s.coupling->start(p, 1e-3);
  }
  s.advance(4), note();
  result.particles = s.coupling->report().particles;
  result.eps.assign(8 * 8 * 16, 0.0);
  for_each(s.fluid.own_cells_, [&](int i, int j, int k) { result.eps[i + 8 * (j + 8 * k)] = s.fluid.eps_(i, j, k); });
  constexpr int kColumns = kParticleColumns + kStepColumns;
  result.state.assign((kGrains + 2) * kColumns, 0.0);
  for (std::size_t q = 0; q < s.bodies.x.size(); ++q) {
    double* const row = &result.state[s.bodies.tag[q] * kColumns];
    std::copy(s.bodies.state[q].begin(), s.bodies.state[q].end(), row);
    std::copy(s.bodies.step[q].begin(), s.bodies.step[q].end(), row + kParticleColumns);
  }
  for (auto* list : {&result.eps, &result.state, &result.source})
    MPI_Allreduce(MPI_IN_PLACE, list->data(), int(list->size()), MPI_DOUBLE, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &result.read_error, 1, MPI_DOUBLE, MPI_MAX, comm);
  return result;
}

// Every deposit with every read, A and B, around every kind of body.
TEST(OpenNodes, VolumeMomentumAndBitsAreKeptByAllMethods) {
  double momentum = 0, volume = 0, read_error = 0;
  int n = 0;
  for (int body = 0; body < kBodies; ++body)
    for (Deposit deposit : {Deposit::kCentroid, Deposit::kTrilinear, Deposit::kExact, Deposit::kCube})
      for (Read read : {Read::kCell, Read::kTrilinear, Read::kFine, Read::kFineTrilinear, Read::kKernel, Read::kCube}) {
        const Formulation form = (int(deposit) + int(read)) % 2 ? Formulation::kA : Formulation::kB;
        const Result all = run(MPI_COMM_WORLD, Body(body), deposit, read, form);
        const std::string what = "body " + std::to_string(body) + " deposit " + std::to_string(int(deposit)) +
                                 " read " + std::to_string(int(read));
        EXPECT_EQ(all.particles, kGrains - 1) << what;
        EXPECT_LE(all.volume_error, 1e-13) << what;
        EXPECT_LE(all.momentum_error, 1e-14) << what;
        // Random faces leave fine cells that no face of a direction leads to: there nothing flows that way.
        if (!(body == kRandom && reads_fine_cells(read))) {
          EXPECT_LE(all.read_error, 1e-13) << what;
          read_error = std::max(read_error, all.read_error);
        }
        volume = std::max(volume, all.volume_error), momentum = std::max(momentum, all.momentum_error);
        ++n;
        if (rank_of(MPI_COMM_WORLD) > 0 || ranks_of(MPI_COMM_WORLD) == 1) continue;
        const Result one = run(MPI_COMM_SELF, Body(body), deposit, read, form);
        long long differ = 0;
        for (std::size_t m = 0; m < one.eps.size(); ++m) differ += one.eps[m] != all.eps[m];
        EXPECT_EQ(differ, 0) << what << ": eps";
        for (std::size_t m = 0; m < one.state.size(); ++m) differ += one.state[m] != all.state[m];
        EXPECT_EQ(differ, 0) << what << ": particles";
        for (std::size_t m = 0; m < one.source.size(); ++m) differ += one.source[m] != all.source[m];
        EXPECT_EQ(differ, 0) << what << ": source";
      }
  if (rank_of(MPI_COMM_WORLD) == 0)
    printf("             %d scenes: volume error %.1e, momentum error %.1e, uniform velocity read to %.1e\n", n, volume,
           momentum, read_error);
}

// Grains on one side of a wall, as near to it as they can be: the other side doesn't know of them.
TEST(OpenNodes, NothingGoesThroughWalls) {
  for (Body body : {kThickWall, kThinWall})
    for (int ratio : {2, 4})
      for (Deposit deposit : {Deposit::kCentroid, Deposit::kTrilinear, Deposit::kExact, Deposit::kCube})
        for (Read read :
             {Read::kCell, Read::kTrilinear, Read::kFine, Read::kFineTrilinear, Read::kKernel, Read::kCube}) {
          Vessel s(MPI_COMM_WORLD, ratio);
          cut(s.fluid, shares_of(body));
          s.settings.deposit = deposit, s.settings.read = read;
          s.settings.formulation = Formulation::kA, s.settings.hold_flux = Choice::kOn;
          const double from = wall_end(body);
          s.fluid.set(s.fluid.u_, [&](int, const Vec3& x) { return x[0] > from - 0.01 ? 100.0 : 1.0; });
          for (int d = 0; d < 3; ++d)
            for_each(s.fluid.u_[d].box(), [&](int i, int j, int k) {
              if (s.fluid.state_[d](i, j, k) == FaceState::kFixed) s.fluid.u_[d](i, j, k) = 0;
            });
          s.fluid.mean_ = s.fluid.u_;
          for (int q = 0; q < 40; ++q)
            s.add({0.34 + 0.001 * q, 0.5 + 0.45 * std::sin(2.0 * q), 1 + 0.95 * std::cos(1.3 * q)}, {0.1, 0, 0}, q + 1,
                  0.035);
          double most = 0, weighed = 0;
          s.fluid.on_advance = [&](double, const VoidFractionInTime&, const Interphase& x) {
            for (int d = 0; d < 3; ++d) {
              const Array3<double> f = source_of(x, d, s.fluid.own_faces_[d]);
              for_each(f.box(), [&](int i, int j, int k) {
                const double at = d == 0 ? s.grid.axis[0].node(i) : s.grid.axis[0].centre(i);
                (at > from - 0.01 ? most : weighed) += std::abs(f(i, j, k));
              });
            }
          };
          s.begin();
          for (int n = 0; n < 2; ++n) s.advance(3);
          double solids = 0, all[2] = {0, 0};
          for_each(s.fluid.own_cells_, [&](int i, int j, int k) {
            if (s.grid.axis[0].centre(i) > from) most = std::max(most, 1 - s.fluid.eps_(i, j, k));
            solids += 1 - s.fluid.eps_(i, j, k);
          });
          EXPECT_EQ(most, 0) << "body " << body << " ratio " << ratio << " deposit " << int(deposit) << " read "
                             << int(read);
          double mine[2] = {solids, weighed};
          MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
          EXPECT_GT(all[0], 0);
          EXPECT_GT(all[1], 0);
          for (const auto& state : s.bodies.state)
            for (int d = 0; d < 3; ++d) EXPECT_NEAR(state[kFluidVelocity + d], 1, 1e-13) << int(read);
        }
}

ParticleGrid nodes_of(MPI_Comm comm, const FakeFluid& fluid, int ratio) {
  ParticleGrid nodes(fluid.grid(), {ratio, ratio, ratio});
  nodes.take_open_part(comm, fluid, {1, 1, 1});
  return nodes;
}

TEST(OpenNodes, FamiliesKeepVolumesAndHaveRoom) {
  for (Body body : {kVessel, kRandom, kThickWall, kThinWall})
    for (int ratio : {1, 2, 4}) {
      Vessel s(MPI_COMM_WORLD, ratio);
      cut(s.fluid, shares_of(body));
      const ParticleGrid nodes = nodes_of(MPI_COMM_WORLD, s.fluid, ratio);
      const OpenNodes& open = *nodes.open_nodes();
      double sums[3] = {0, 0, 0}, all[3];
      long long counts[3] = {0, 0, 0}, all_counts[3];
      const double whole = std::pow(0.125 * ratio, 3);
      for_each(open.open_part().box(), [&](int i, int j, int k) {
        const double part = open.open_part()(i, j, k), volume = nodes.volume(i, j, k);
        sums[0] += part, sums[1] += volume;
        counts[0] += part<whole*(1 - 1e-12), counts[1] += part == 0, counts[2] += part> 0 && volume == 0;
        if (part > 0) {
          EXPECT_GE(nodes.shown_volume(i, j, k), part);
        }
        // Who is open enough has a value of its own.
        if (part >= OpenNodes::kOwnValue * whole) {
          EXPECT_GE(volume, part);
        }
      });
      for_each(s.fluid.own_cells_,
               [&](int i, int j, int k) { sums[2] += s.fluid.open_->theta()(i, j, k) * s.grid.volume(i, j, k); });
      MPI_Allreduce(sums, all, 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
      MPI_Allreduce(counts, all_counts, 3, MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
      EXPECT_NEAR(all[0], all[2], 1e-13);
      EXPECT_NEAR(all[1], all[2], 1e-13);
      const OpenNodes::Figures& f = open.figures();
      EXPECT_EQ(f.cut, all_counts[0]);
      EXPECT_EQ(f.closed, all_counts[1]);
      EXPECT_EQ(f.merged, all_counts[2]);
      if (body != kRandom) {
        EXPECT_EQ(f.split, 0);
        EXPECT_GE(f.smallest, 0.5);
      }
      if (body == kVessel && ratio < 4) {
        EXPECT_GT(f.merged, 0);
        EXPECT_LT(f.smallest, 1);
      }
      if (rank_of(MPI_COMM_WORLD) == 0)
        printf("             body %d, ratio %d: %lld cut, %lld closed, %lld merged, %lld split, smallest %.3f\n", body,
               ratio, f.cut, f.closed, f.merged, f.split, f.smallest);
    }
}

// A wall inside a node splits it, but for a sliver at a corner; a slit that ends leaves a way round; diagonal nodes see each other past one closed node,
// not past two.
TEST(OpenNodes, SightAndSplitNodes) {
  const auto made = [](int ratio, std::function<bool(const Vec3&)> closed) {
    Vessel s(MPI_COMM_WORLD, ratio);
    cut(s.fluid, blocks(std::move(closed)));
    return nodes_of(MPI_COMM_WORLD, s.fluid, ratio);
  };
  const ParticleGrid split = made(4, [](const Vec3& x) { return x[0] > 0.625 && x[0] < 0.875; });
  EXPECT_EQ(split.open_nodes()->figures().split, 2 * 4);
  // A single cell of 64 that is cut off at a corner is a sliver, a row of four is a part.
  for (int row : {1, 4}) {
    const ParticleGrid cornered = made(4, [row](const Vec3& x) {
      const Int3 c{int(x[0] / 0.125), int(x[1] / 0.125), int(x[2] / 0.125)};
      const bool along = c[2] > 7 - row && c[2] <= 7;
      return (along && ((c[0] == 6 && c[1] == 7) || (c[0] == 7 && c[1] == 6))) ||
             (c[0] == 7 && c[1] == 7 && c[2] == 7 - row);
    });
    EXPECT_EQ(cornered.open_nodes()->figures().split, row == 4);
  }
  const auto sees = [](const ParticleGrid& nodes, const Int3& at, const Int3& offset) {
    const Array3<long long>& sight = nodes.open_nodes()->sight();
    int mine = 0, any = 0;
    if (sight.box().contains(at[0], at[1], at[2]))
      mine = (sight(at[0], at[1], at[2]) & OpenNodes::seen(offset[0], offset[1], offset[2])) != 0;
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return any == 1;
  };
  // Nodes of 2 cells: 4 x 4 x 8. A thin wall (cell 3) that ends at y = 0.5.
  const ParticleGrid slit = made(2, [](const Vec3& x) { return x[0] > 0.375 && x[0] < 0.5 && x[1] < 0.5; });
  EXPECT_FALSE(sees(slit, {1, 0, 3}, {1, 0, 0}));
  EXPECT_FALSE(sees(slit, {2, 0, 3}, {-1, 0, 1}));
  EXPECT_TRUE(sees(slit, {1, 2, 3}, {1, 0, 0}));
  EXPECT_TRUE(sees(slit, {1, 1, 3}, {1, 1, 0}));
  EXPECT_FALSE(sees(slit, {0, 0, 0}, {-1, 0, 0}));  // there is none
  const ParticleGrid one = made(2, [](const Vec3& x) { return x[0] < 0.25 && x[1] > 0.25 && x[1] < 0.5; });
  EXPECT_TRUE(sees(one, {0, 0, 2}, {1, 1, 0}));
  EXPECT_FALSE(sees(one, {0, 0, 2}, {0, 1, 0}));
  const ParticleGrid two = made(2, [](const Vec3& x) {
    return (x[0] < 0.25 && x[1] > 0.25 && x[1] < 0.5) || (x[1] < 0.25 && x[0] > 0.25 && x[0] < 0.5);
  });
  EXPECT_FALSE(sees(two, {0, 0, 2}, {1, 1, 0}));
  EXPECT_FALSE(sees(two, {0, 1, 2}, {1, -1, 0}));  // both closed
  EXPECT_TRUE(sees(two, {2, 2, 2}, {-1, -1, 0}));
}

// A grain whose centre lies in a closed node counts in the nearest open one; one deep in a body is outside the fluid, and
// what it had received before it got there comes back.
TEST(OpenNodes, GrainsInWallsAndBehind) {
  for (Deposit deposit : {Deposit::kCentroid, Deposit::kTrilinear, Deposit::kExact, Deposit::kCube})
    for (Read read : {Read::kCell, Read::kTrilinear, Read::kFine, Read::kKernel}) {
      Vessel s(MPI_COMM_WORLD);
      cut(s.fluid, blocks([](const Vec3& x) { return x[0] > 0.25; }));
      s.settings.deposit = deposit, s.settings.read = read;
      s.flow(kFlow);
      s.add({0.4, 0.4, 1.1}, {0, 0, 0}, 1, 0.03);  // in the closed node beside
      s.add({0.2, 0.9, 1.1}, {0, 0, 1}, 2, 0.03);  // in the fluid
      s.add({0.8, 0.4, 0.4}, {0, 0, 1}, 3, 0.03);  // deep in the body
      s.begin();
      s.advance(3);
      const Report& r = s.coupling->report();
      EXPECT_EQ(r.particles, 2);
      EXPECT_EQ(r.in_walls, 1);
      EXPECT_EQ(r.behind_walls, 1);
      EXPECT_EQ(s.coupling->in_closed_cells(s.bodies.view()), 1);
      EXPECT_LE(r.solid_volume_error, 1e-13);
      EXPECT_LE(r.momentum_error, 1e-14);
      for (std::size_t q = 0; q < s.bodies.x.size(); ++q) {
        const bool inside = s.bodies.tag[q] != 3;
        EXPECT_EQ(s.bodies.step[q][kDragCoefficient] > 0, inside) << s.bodies.tag[q];
        for (int d = 0; d < 3; ++d)
          EXPECT_NEAR(s.bodies.state[q][kFluidVelocity + d], inside ? kFlow[d] : 0.0, 1e-13) << s.bodies.tag[q];
      }
      // Solids of the first in the node at 0 to 0.25, 0.25 to 0.5, 1 to 1.25; more of it with weights.
      for_each(s.fluid.own_cells_, [&](int i, int j, int k) {
        if (i == 0 && j == 2 && k == 8) {
          EXPECT_NEAR(1 - s.fluid.eps_(i, j, k), sphere_volume(0.03) / std::pow(0.25, 3), 1e-12);
        }
      });
      for (std::size_t q = 0; q < s.bodies.x.size(); ++q)
        if (s.bodies.tag[q] == 2) s.bodies.x[q][0] = 0.8;
      s.advance(3);
      EXPECT_EQ(r.particles, 1);
      EXPECT_EQ(r.behind_walls, 2);
      EXPECT_LE(r.momentum_error, 1e-14);
    }
}

/// Hexagonal layers of spheres of diameter 1, their centres a radius away from the wall of a cylinder or more.
Bodies packing(double R, const Vec3& axis, double spacing, int layers, double& height) {
  Bodies b;
  const double dz = std::sqrt(2.0 / 3) * spacing, row = std::sqrt(0.75) * spacing, turn = 0.3;
  height = layers * dz;
  const int n = int(2 * R / spacing) + 2;
  int tag = 0;
  for (int l = 0; l < layers; ++l)
    for (int j = -n; j <= n; ++j)
      for (int i = -n; i <= n; ++i) {
        const double x = (i + 0.5 * (j & 1)) * spacing + (l & 1) * 0.5 * spacing;
        const double y = j * row + (l & 1) * row / 3;
        if (std::hypot(x, y) > R - 0.5) continue;
        b.add({axis[0] + x * std::cos(turn) - y * std::sin(turn), axis[1] + x * std::sin(turn) + y * std::cos(turn),
               (l + 0.5) * dz},
              0.5, 1000, {0, 0, 0}, ++tag);
      }
  return b;
}

// A packing against a curved wall, nodes of three diameters, the axis anywhere on the grid: eps of nodes at the wall
// against that by exact volumes, node by node and in rings, and none denser than the packing is anywhere.
TEST(OpenNodes, PackingAgainstACurvedWall) {
  const double R = 6;
  double height = 0;
  for (const auto& at : {std::array<double, 2>{7.5, 7.5}, {7.1, 8.3}, {8.2, 7.9}}) {
    const Bodies all = packing(R, {at[0], at[1], 0}, 1.08, 14, height);
    const FineGrid grid = make_grid({0, 0, 0}, {15, 15, height}, {20, 20, 16}, {false, false, true});
    FakeFluid fluid(MPI_COMM_WORLD, grid, make_layout(grid, ranks_of(MPI_COMM_WORLD), {4, 4, 4}));
    cut(fluid,
        sampled([&](const Vec3& x) { return std::hypot(x[0] - at[0], x[1] - at[1]) < R; }, {0.75, 0.75, height / 16}));
    const ParticleGrid nodes = nodes_of(MPI_COMM_WORLD, fluid, 4), plain(grid, {4, 4, 4});
    const OpenNodes& open = *nodes.open_nodes();
    const Layout layout = node_layout(fluid.layout(), nodes);
    Bodies mine = share_of(all, grid, MPI_COMM_WORLD);
    Particles p = mine.view();
    std::vector<int> who(p.n);
    std::iota(who.begin(), who.end(), 0);
    const auto deposit = [&](const ParticleGrid& on, Deposit kind) {
      VolumeDeposit d(MPI_COMM_WORLD, on, layout, make_region(grid, MPI_COMM_WORLD, 0.1), kind, 3.0);
      d.prepare(0.5);
      Array3<long long> solid(layout.cells(rank_of(MPI_COMM_WORLD)));
      d(p, who, solid);
      return solid;
    };
    // Exact volumes in the boxes of the families.
    Array3<long long> exact = deposit(plain, Deposit::kExact);
    open.gather_up(slot_of(exact));
    const double unit = FixedPoint(sphere_volume(0.5), 15 * nodes.largest_volume() / sphere_volume(0.5)).unit();
    double densest = 1;
    for_each(exact.box(), [&](int i, int j, int k) {
      if (nodes.volume(i, j, k) > 0)
        densest = std::min(densest, 1 - double(exact(i, j, k)) * unit / nodes.volume(i, j, k));
    });
    MPI_Allreduce(MPI_IN_PLACE, &densest, 1, MPI_DOUBLE, MPI_MIN, MPI_COMM_WORLD);
    for (Deposit kind : {Deposit::kTrilinear, Deposit::kExact, Deposit::kCube, Deposit::kCentroid}) {
      const Array3<long long> solid = deposit(nodes, kind);
      constexpr int kRings = 4;  // of one and a half diameters, from the wall inwards, by the masters' open parts
      double sums[3 + 2 * kRings] = {}, least = 1, worst = 0, largest[2], found[2];
      for_each(solid.box(), [&](int i, int j, int k) {
        const double volume = nodes.volume(i, j, k);
        if (volume == 0 || (volume == nodes.Grid::volume(i, j, k) && !open.in_family(i, j, k))) {
          EXPECT_TRUE(volume > 0 || solid(i, j, k) == 0);
          return;
        }
        const double by = double(solid(i, j, k)) * unit / volume, is = double(exact(i, j, k)) * unit / volume;
        const double x = nodes.axis[0].centre(i) + open.off_centre(0, i, j, k) - at[0],
                     y = nodes.axis[1].centre(j) + open.off_centre(1, i, j, k) - at[1];
        const int ring = std::min(int((R - std::hypot(x, y)) / 1.5), kRings - 1);
        sums[0] += volume * (by - is), sums[1] += (by - is) * (by - is), sums[2] += 1;
        sums[3 + 2 * ring] += volume * (by - is), sums[4 + 2 * ring] += volume;
        least = std::min(least, 1 - by), worst = std::max(worst, std::abs(by - is));
      });
      MPI_Allreduce(MPI_IN_PLACE, sums, 3 + 2 * kRings, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
      largest[0] = -least, largest[1] = worst;
      MPI_Allreduce(largest, found, 2, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
      double in_rings = 0, volume = 0;
      for (int r = 0; r < kRings; ++r) {
        volume += sums[4 + 2 * r];
        if (sums[4 + 2 * r] > 0) in_rings = std::max(in_rings, std::abs(sums[3 + 2 * r] / sums[4 + 2 * r]));
      }
      const double mean = sums[0] / volume, rms = std::sqrt(sums[1] / sums[2]);
      if (rank_of(MPI_COMM_WORLD) == 0)
        printf(
            "             axis %.1f %.1f, deposit %d: eps at the wall off by %.4f in the mean, %.4f in rings, %.4f rms "
            "of "
            "nodes; least %.3f, exact %.3f\n",
            at[0], at[1], int(kind), mean, in_rings, rms, -found[0], densest);
      EXPECT_LT(std::abs(mean), 0.01);
      if (kind == Deposit::kCentroid) continue;  // whole spheres here or there
      EXPECT_LT(in_rings, 0.02);
      EXPECT_LT(rms, 0.025);
      EXPECT_GT(-found[0], densest - 0.02);
      if (kind == Deposit::kExact) {
        EXPECT_LT(found[1], 1e-3);
      }
    }
  }
}

// Linear profiles about the open parts' centres: the node's solids are kept, the bounds too, and no slope leads through a
// wall.
TEST(OpenNodes, ProlongationKeepsTheOpenPart) {
  for (Body body : {kVessel, kRandom, kThickWall, kThinWall}) {
    Vessel s(MPI_COMM_WORLD, 2);
    cut(s.fluid, shares_of(body));
    const ParticleGrid nodes = nodes_of(MPI_COMM_WORLD, s.fluid, 2);
    const OpenNodes& open = *nodes.open_nodes();
    const Box own_nodes = open.open_part().box(), own = s.fluid.own_cells_;
    CellField<ParticleGrid> node;
    CellField<FineGrid> fine;
    node.reset(own_nodes.empty() ? own_nodes : own_nodes.grown(1), -5.0);
    fine.reset(own.empty() ? own : own.grown(2), -5.0);
    for_each(own_nodes, [&](int i, int j, int k) {
      node(i, j, k) = open.open_part()(i, j, k) > 0 ? 0.5 + 0.05 * i + 0.04 * j + 0.02 * k : 1.0;
    });
    open.hand_down(slot_of<double>(node));
    const Prolongation linear(MPI_COMM_WORLD, s.grid, s.fluid.layout(), nodes, Prolong::kLinear, 0.35);
    linear(node, fine);
    double given = 0, made = 0, sloped = 0;
    for_each(own_nodes, [&](int I, int J, int K) {
      given += (1 - node(I, J, K)) * open.open_part()(I, J, K);
      double sum = 0;
      for_each(nodes.block(I, J, K), [&](int i, int j, int k) {
        EXPECT_GE(fine(i, j, k), 0.35 - 1e-15);
        EXPECT_LE(fine(i, j, k), 1 + 1e-15);
        sum += (1 - fine(i, j, k)) * s.fluid.open_->theta()(i, j, k) * s.grid.volume(i, j, k);
        sloped = std::max(sloped, std::abs(fine(i, j, k) - node(I, J, K)));
      });
      EXPECT_NEAR(sum, (1 - node(I, J, K)) * open.open_part()(I, J, K), 1e-15);
      made += sum;
    });
    double mine[3] = {given, made, sloped}, all[3];
    MPI_Allreduce(mine, all, 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    EXPECT_NEAR(all[0], all[1], 1e-14);
    if (body != kRandom) {  // there nearly all nodes are in families
      EXPECT_GT(all[2], 0);
    }
  }
}

}  // namespace
}  // namespace twogrid_test
