// The coupling as a whole, interval by interval in a closed box: what every method keeps, what particles bring with them
// that come and go, and what is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "cfd/parallel/ranks.h"
#include "coupling/coupling.h"
#include "coupling/forces/drag.h"
#include "coupling/methods.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A closed box with walls, a few particles, whatever method: one interval at a time, by hand.
struct SmallBox {
  FineGrid grid;
  FakeFluid fluid;
  Settings settings;
  Bodies bodies;
  std::unique_ptr<Coupling> coupling;
  explicit SmallBox(const Int3& cells = {8, 8, 16}, const Int3& ratio = {2, 2, 2})
      : grid(make_grid({0, 0, 0}, {1, 1, 2}, cells, {false, false, false})),
        fluid(MPI_COMM_WORLD, grid, make_layout(grid, ranks_of(MPI_COMM_WORLD), ratio), 1.2, 1e-2) {
    settings.id = "gas";
    settings.ratio = ratio;
    settings.fine = cells;
    settings.drag = "ergun/wenyu";
    choose(*find_method("paper"), 0, settings);
    settings.hold_flux = Choice::kOff;
  }
  void add(const Vec3& x, const Vec3& v, int tag, double radius = 0.05) { add(x, v, tag, radius, x); }
  /// held_at: of the rank that has this place.
  void add(const Vec3& x, const Vec3& v, int tag, double radius, const Vec3& held_at) {
    Bodies one;
    one.add(held_at, radius, 1000, v, tag);
    const Bodies mine = share_of(one, grid, MPI_COMM_WORLD);
    if (mine.x.size() == 1) bodies.add(x, radius, 1000, v, tag);
  }
  /// above: how far the box goes on above the fluid (m).
  void begin(double above = 0) {
    ParticleRegion r = make_region(grid, MPI_COMM_WORLD, 0.02);
    if (r.hi[2] == grid.axis[2].hi()) r.hi[2] += above;
    coupling = std::make_unique<Coupling>(MPI_COMM_WORLD, settings, fluid, r.lo, r.hi, r.reach);
    Particles p = bodies.view();
    coupling->start(p, 1e-3);
    coupling->force(p, 1e-3, false);
  }
  void advance(int steps) {
    Particles p = bodies.view();
    for (int s = 0; s < steps - 1; ++s) {
      for (auto& f : bodies.f) f = {0, 0, 0};
      coupling->force(p, 1e-3, true);
    }
    coupling->advance(p, steps, 1e-3);
    for (auto& f : bodies.f) f = {0, 0, 0};
    coupling->force(p, 1e-3, true);
  }
};

// All ways of depositing, prolonging and reading, A and B: volume and momentum are kept, particles at walls included, and
// beside and inside a body.
TEST(CouplingMethods, VolumeAndMomentumAreKept) {
  double worst_momentum = 0, worst_volume = 0;
  for (Deposit deposit : {Deposit::kCentroid, Deposit::kTrilinear, Deposit::kExact, Deposit::kCube})
    for (Read read : {Read::kCell, Read::kTrilinear, Read::kFine, Read::kFineTrilinear, Read::kKernel, Read::kCube})
      for (Formulation form : {Formulation::kA, Formulation::kB})
        for (bool body : {false, true}) {
          SmallBox s;
          if (body) cut_corner(s.fluid);
          s.settings.deposit = deposit;
          s.settings.read = read;
          s.settings.formulation = form;
          s.settings.prolong = form == Formulation::kA ? Prolong::kLinear : Prolong::kConstant;
          s.settings.kernel_width = 0.3;
          s.settings.cube_edge = 0.25;
          s.settings.hold_flux = form == Formulation::kA ? Choice::kOn : Choice::kOff;
          for (int q = 0; q < 40; ++q)
            s.add({0.5 + 0.52 * std::sin(1.0 + q), 0.5 + 0.5 * std::cos(2.3 * q), 1 + std::sin(0.7 * q)},
                  {0.1 * q, -0.2, 0.3}, q + 1);
          s.fluid.set(s.fluid.u_, [](int d, const Vec3& x) { return 2.0 + d + std::sin(3 * x[0] + x[2]); });
          s.fluid.mean_ = s.fluid.u_;
          for (int d = 0; d < 3; ++d)  // walls are at rest
            for_each(s.fluid.u_[d].box(), [&](int i, int j, int k) {
              if (s.fluid.state_[d](i, j, k) == FaceState::kFixed)
                s.fluid.u_[d](i, j, k) = s.fluid.mean_[d](i, j, k) = 0;
            });
          s.begin();
          for (int n = 0; n < 3; ++n) {
            s.advance(4);
            EXPECT_EQ(s.coupling->report().particles, 40);
            worst_momentum = std::max(worst_momentum, s.coupling->report().momentum_error);
            worst_volume = std::max(worst_volume, s.coupling->report().solid_volume_error);
          }
        }
  EXPECT_LE(worst_momentum, 1e-14);
  EXPECT_LE(worst_volume, 1e-13);
  if (rank_of(MPI_COMM_WORLD) == 0)
    printf("             48 methods, without and with a body: momentum error %.1e, volume error %.1e\n", worst_momentum,
           worst_volume);
}

// An inserted particle replaces fluid at once: if it counted as motion the fluid would be pushed aside in one interval,
// a pressure peak. d(eps)/dt is zero at every time in the interval; eps at its begin has changed by the particle's
// volume.
TEST(CouplingInsertion, ReplacesFluid) {
  SmallBox s;
  s.add({0.3, 0.3, 0.3}, {0, 0, 0}, 1);
  s.begin();
  double worst = 0, smallest = 0;
  long long sources = 0;
  CellField<FineGrid> before = s.fluid.eps_;
  s.fluid.on_advance = [&](double D, const VoidFractionInTime& eps, const Interphase& x) {
    sources += x.replaced;
    for_each(s.fluid.own_cells_, [&](int i, int j, int k) {
      const std::ptrdiff_t m = eps.end->index(i, j, k);
      const double change = eps.at(m, 0, D) - before(i, j, k);
      smallest = std::min(smallest, change);
      if (!x.replaced) worst = std::max(worst, std::abs(change));
      for (double t : {0.0, 0.3, 0.6})
        worst = std::max(worst, std::abs(eps.at(m, t + 0.1, D) - eps.at(m, t, D)) / (0.1 * D));
    });
    before = *eps.end;
  };
  s.advance(5);
  s.add({0.7, 0.6, 1.4}, {0, 0, 0}, 2);
  s.advance(5);
  long long all = 0;
  MPI_Allreduce(&sources, &all, 1, MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_GE(all, 1);
  EXPECT_LT(worst, 1e-10);
  double least = 0;
  MPI_Allreduce(&smallest, &least, 1, MPI_DOUBLE, MPI_MIN, MPI_COMM_WORLD);
  const double volume = 4.18879020478639098462 * 0.05 * 0.05 * 0.05;
  EXPECT_NEAR(least, -volume / (0.25 * 0.25 * 0.25), 1e-9 * std::abs(least));
  EXPECT_NEAR(s.coupling->report().volume_inserted, volume, 1e-15);
  EXPECT_EQ(s.coupling->report().volume_vanished, 0);
  s.advance(5);  // no longer new
  EXPECT_EQ(s.coupling->report().volume_inserted, 0);
  EXPECT_LT(worst, 1e-10);
  if (!s.bodies.x.empty() && s.bodies.tag.back() == 2) {
    EXPECT_GT(s.bodies.step.back()[kDragCoefficient], 0);
    s.bodies = Bodies();
  }
  s.advance(5);
  EXPECT_GT(s.coupling->report().volume_vanished, 0.9 * volume);
}

// A particle that moves into the domain pushes fluid aside, unlike one that is inserted there, and its path before that
// is none of the fluid's affair. Without the test, particles from a feed beside the fluid would take fluid's place
// without moving it, and those that come back from the freeboard would seem to have run their whole way in one
// interval.
TEST(CouplingInsertion, ParticleThatComesInIsNotInserted) {
  for (bool was_inside : {false, true}) {
    SmallBox s;
    s.fluid.open_side(2, true);
    s.add({0.5, 0.5, was_inside ? 1.99 : 2.1}, {0, 0, -1}, 1);
    s.begin();
    auto move = [&](double z) {
      for (auto& x : s.bodies.x) x[2] = z;
    };
    move(2.1);
    for (int q = 0; q < 3; ++q) s.advance(5);
    long long sources = 0;
    s.fluid.on_advance = [&](double, const VoidFractionInTime&, const Interphase& x) { sources += x.replaced; };
    move(1.9);
    s.advance(5);
    EXPECT_EQ(sources, 0) << "was inside: " << was_inside;
    EXPECT_EQ(s.coupling->report().particles, 1);
    EXPECT_EQ(s.coupling->report().volume_inserted, 0);
    for (auto& state : s.bodies.state)
      EXPECT_NEAR(state[kPathVelocity + 2], -0.2 / 5e-3, 1e-10) << "was inside: " << was_inside;
  }
}

// What a particle received before it left the domain still comes back to the fluid.
TEST(CouplingLedger, LeavingParticleSettlesItsAccount) {
  SmallBox s;
  s.fluid.open_side(2, true);
  s.add({0.5, 0.5, 1.99}, {0, 0, 1}, 1);
  s.fluid.set(s.fluid.u_, [](int d, const Vec3&) { return d == 2 ? 3.0 : 0.0; });
  s.fluid.mean_ = s.fluid.u_;
  s.begin();
  double source = 0;
  s.fluid.on_advance = [&](double, const VoidFractionInTime&, const Interphase& x) {
    source = 0;
    const Array3<double> f = source_of(x, 2, s.fluid.own_faces_[2]);
    for (std::size_t m = 0; m < f.size(); ++m) source += f.data()[m];
  };
  for (auto& x : s.bodies.x) x[2] = 2.5;
  s.advance(5);
  double all = 0;
  MPI_Allreduce(&source, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_LT(all, 0);
  EXPECT_LE(s.coupling->report().momentum_error, 1e-14);
  EXPECT_EQ(s.coupling->report().particles, 0);
  for (auto& step : s.bodies.step) {
    EXPECT_EQ(step[kDragCoefficient], 0);
    EXPECT_EQ(step[kImpulse + 2], 0);
  }
}

// Many particles that leave at once, into one node: their sum has to fit, however few stay behind. Integers that
// overflow would hand the fluid any momentum.
TEST(CouplingLedger, AllParticlesLeaveAtOnce) {
  SmallBox s;
  s.fluid.open_side(2, true);
  for (int q = 0; q < 50; ++q) s.add({0.55, 0.55, 1.99}, {0, 0, 1}, q + 1);
  s.fluid.set(s.fluid.u_, [](int d, const Vec3&) { return d == 2 ? 3.0 : 0.0; });
  s.fluid.mean_ = s.fluid.u_;
  s.begin();
  for (auto& x : s.bodies.x) x[2] = 2.5;
  s.advance(5);
  EXPECT_EQ(s.coupling->report().particles, 0);
  EXPECT_LE(s.coupling->report().momentum_error, 1e-14);
}

// One cell from wall to wall: the drag across it has no face to go to, the walls take it, and the account says so.
// Without this test it would do if that part were left out of the account, for elsewhere walls take nothing.
TEST(CouplingLedger, WallsOfAOneCellGapTakeTheDragAcrossIt) {
  if (ranks_of(MPI_COMM_WORLD) > 4) GTEST_SKIP();  // x would be cut
  for (Formulation form : {Formulation::kA, Formulation::kB}) {
    SmallBox s({1, 8, 16}, {1, 2, 2});
    s.settings.formulation = form;
    for (int q = 0; q < 10; ++q) s.add({0.5, 0.08 + 0.09 * q, 0.1 + 0.18 * q}, {0.4, 0.1, -0.2}, q + 1);
    s.fluid.set(s.fluid.u_, [](int d, const Vec3& x) { return d == 2 && x[2] > 0 && x[2] < 2 ? 3.0 : 0.0; });
    s.fluid.mean_ = s.fluid.u_;
    s.begin();
    for (int n = 0; n < 3; ++n) {
      s.advance(4);
      EXPECT_LE(s.coupling->report().momentum_error, 1e-14);
      for (auto& state : s.bodies.state) EXPECT_LT(state[kDragForce], 0);  // across
    }
  }
}

// A particle a little outside the box is on its way out, and its volume still counts; where the box goes on, the
// particles beside the fluid's domain are no part of it. Else a layer of half a skin of them would be squeezed into the
// outermost nodes.
TEST(CouplingDomain, EndsWhereTheBoxGoesOn) {
  for (double above : {0.0, 1.0}) {
    SmallBox s;
    s.add({0.5, 0.5, 1.99}, {0, 0, 0}, 1);
    s.add({0.5, 0.5, 2.01}, {0, 0, 0}, 2);
    s.begin(above);
    EXPECT_EQ(s.coupling->report().particles, above > 0 ? 1 : 2);
    s.advance(5);
    EXPECT_EQ(s.coupling->report().particles, above > 0 ? 1 : 2);
  }
}

// Spheres of two sizes: y = d/<d> with the Sauter mean of the node, whoever holds its particles, and the drag law gets
// it; both formulations give a particle its drag and the force of the gradient that its node's drag makes, V_p D/eps.
// With the arithmetic mean, or the mean of a rank's own particles, or the drag over eps, all monodisperse tests would
// pass.
TEST(CouplingPolydisperse, SizeRatioIsThatOfTheNodesSauterMean) {
  for (Formulation form : {Formulation::kA, Formulation::kB}) {
    SmallBox s;
    s.settings.drag = "beetstra/poly";
    s.settings.formulation = form;
    const double big = 0.05, small = 0.02;
    // One node, x and y 0.5 to 0.75, z 1 to 1.25: a big one held by the rank below, and three small ones.
    s.add({0.6, 0.6, 1.01}, {0, 0, 0}, 1, big, {0.6, 0.6, 0.99});
    for (int q = 0; q < 3; ++q) s.add({0.55 + 0.05 * q, 0.7, 1.2}, {0, 0.3, 0}, 2 + q, small);
    s.add({0.1, 0.1, 0.1}, {0, 0, 0}, 5, small);  // alone in its node
    s.fluid.set(s.fluid.u_, [](int d, const Vec3& x) {
      const bool wall = d == 2 && (x[2] < 1e-9 || x[2] > 2 - 1e-9);
      return d == 2 && !wall ? 3.0 : 0.0;
    });
    s.fluid.mean_ = s.fluid.u_;
    s.begin();
    auto verify = [&] {
      const double sauter = 2 * (std::pow(big, 3) + 3 * std::pow(small, 3)) / (big * big + 3 * small * small);
      const double solids = 4 * kPi / 3 * (std::pow(big, 3) + 3 * std::pow(small, 3));
      // Drag of a node's particles per volume and eps; they may be held by several ranks.
      Vec3 gradient[2] = {{0, 0, 0}, {0, 0, 0}};
      for (std::size_t q = 0; q < s.bodies.x.size(); ++q)
        for (int c = 0; c < 3; ++c) {
          const double slip = s.bodies.step[q][kStepVelocity + c] - s.bodies.v[q][c];
          gradient[s.bodies.tag[q] == 5][c] +=
              s.bodies.step[q][kDragCoefficient] * slip / (s.bodies.state[q][kVoidFraction] * std::pow(0.25, 3));
        }
      MPI_Allreduce(MPI_IN_PLACE, gradient, 6, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
      for (std::size_t q = 0; q < s.bodies.x.size(); ++q) {
        const auto& state = s.bodies.state[q];
        const bool lone = s.bodies.tag[q] == 5;
        const double volume = 4 * kPi / 3 * std::pow(s.bodies.radius[q], 3);
        for (int c = 0; c < 3 && form == Formulation::kB; ++c)  // A has the fluid's residual besides
          EXPECT_NEAR(state[kPressureForce + c], volume * gradient[lone][c],
                      1e-12 * volume * (1 + std::abs(gradient[lone][c])));
        const double d = 2 * s.bodies.radius[q], y = lone ? 1.0 : d / sauter;
        const double eps = 1 - (lone ? 4 * kPi / 3 * std::pow(small, 3) : solids) / std::pow(0.25, 3);
        EXPECT_NEAR(state[kVoidFraction], eps, 1e-13);
        EXPECT_NEAR(state[kSizeRatio], y, 1e-13);
        double slip = 0;
        for (int c = 0; c < 3; ++c) slip += std::pow(s.bodies.step[q][kStepVelocity + c] - s.bodies.v[q][c], 2);
        const double b = drag_coefficient(*find_drag_law("beetstra/poly"), eps, d, std::sqrt(slip), 1.2, 1e-2, y);
        EXPECT_NEAR(s.bodies.step[q][kDragCoefficient] / b, 1, 1e-12);
      }
    };
    verify();
    for (int n = 0; n < 3; ++n) {
      s.advance(4);
      verify();
      EXPECT_EQ(s.coupling->report().particles, 5);
      EXPECT_LE(s.coupling->report().momentum_error, 1e-14);
      EXPECT_LE(s.coupling->report().solid_volume_error, 1e-13);
    }
  }
}

TEST(CouplingOneWay, TheFluidKnowsNothing) {
  SmallBox s;
  s.settings.one_way = true;
  s.settings.formulation = Formulation::kA;
  s.add({0.5, 0.5, 1.1}, {0, 0, 1}, 1);
  s.fluid.set(s.fluid.u_, [](int d, const Vec3&) { return d == 2 ? 3.0 : 0.0; });
  s.fluid.mean_ = s.fluid.u_;
  s.fluid.set(s.fluid.gradient_, [](int d, const Vec3&) { return d == 2 ? -7.0 : 0.0; });
  s.fluid.on_advance = [&](double, const VoidFractionInTime& eps, const Interphase& x) {
    for (std::size_t m = 0; m < eps.end->size(); ++m) EXPECT_EQ(eps.end->data()[m], 1);
    EXPECT_FALSE(x.reacts() || x.beta_rows);
  };
  s.begin();
  s.advance(5);
  for (auto& state : s.bodies.state) {
    EXPECT_NEAR(state[kPressureForce + 2], 7 * 4.18879020478639098462 * 0.05 * 0.05 * 0.05, 1e-15);
    EXPECT_EQ(state[kVoidFraction], 1);
    EXPECT_GT(state[kDragForce + 2], 0);
  }
  EXPECT_EQ(s.coupling->report().momentum_error, 0);
}

TEST(CouplingSettings, WhatCannotBeServedIsRefused) {
  auto sentence = [](const std::function<void(Settings&)>& spoil) {
    SmallBox s;
    spoil(s.settings);
    try {
      s.begin();
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("taken");
  };
  EXPECT_NE(sentence([](Settings& s) { s.drag = "no/such"; }).find("'no/such'"), std::string::npos);
  EXPECT_NE(sentence([](Settings& s) { s.eps_min = 1.5; }).find("found 1.5"), std::string::npos);
  EXPECT_NE(sentence([](Settings& s) { s.read = Read::kKernel; }).find("width above 0"), std::string::npos);
  EXPECT_NE(sentence([](Settings& s) { s.deposit = Deposit::kCube; }).find("edge above 0"), std::string::npos);
  EXPECT_NE(sentence([](Settings& s) { s.read = Read::kKernel, s.kernel_width = 50; }).find("at most"),
            std::string::npos);
}

}  // namespace
}  // namespace twogrid_test
