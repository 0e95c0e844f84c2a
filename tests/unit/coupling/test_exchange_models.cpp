// The doors for models of the exchange: reading and writing on fine cells, and forces of their own.
//
// Without these tests would pass: a heat that the particles give and the fluid receives elsewhere than they read; a
// share of it lost between ranks, or on cells of unequal size; a lift whose reaction the fluid never feels, or that is
// kept from one coupling to the next and grows.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "coupling/coupling.h"
#include "coupling/forces/exchange_model.h"
#include "coupling/methods.h"
#include "coupling/particles/ledger.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

double total(double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

/// A scalar in fine cells, and its void fraction.
double scalar(const Vec3& x) {
  return std::sin(2 * M_PI * x[0]) + std::cos(2 * M_PI * x[1]) * x[2];
}
double eps_at(const Vec3& x) {
  return 0.7 + 0.2 * std::cos(3 * x[0] - x[1] + x[2]);
}
void set(CellField<FineGrid>& field, const FineGrid& grid, double (*f)(const Vec3&)) {
  for_each(field.box(), [&](int i, int j, int k) {
    field(i, j, k) = f({grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)});
  });
}

TEST(ExchangeOnCells, WhatGoesBackIsTheTransposeOfWhatIsRead) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {true, false, true}, {1.08, 1.05, 1});
  const Layout layout = make_layout(grid, ranks_of(comm), {2, 4, 2});
  FakeFluid fluid(comm, grid, layout);
  CellField<FineGrid> c(fluid.void_fraction().box()), eps(fluid.void_fraction().box());
  set(c, grid, scalar), set(eps, grid, eps_at);
  const auto volume = [&](int i, int j, int k) {
    return grid.axis[0].width(i) * grid.axis[1].width(j) * grid.axis[2].width(k);
  };
  Bodies all;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(0, 1);
  for (int q = 0; q < 200; ++q) all.add({u(random), u(random), 2 * u(random)}, 0.01, 1000, {0, 0, 0}, q + 1);
  for (Read read : {Read::kCell, Read::kTrilinear, Read::kFine, Read::kFineTrilinear, Read::kKernel, Read::kCube})
    for (const CellField<FineGrid>* weight :
         {static_cast<const CellField<FineGrid>*>(nullptr), static_cast<const CellField<FineGrid>*>(&eps)}) {
      Reader reader(comm, fluid, ParticleGrid(grid, reads_fine_cells(read) ? Int3{1, 1, 1} : Int3{2, 4, 2}),
                    make_region(grid, comm, 0.02), read, read == Read::kKernel || read == Read::kCube ? 0.33 : 0.0);
      Bodies bodies = share_of(all, grid, comm);
      const Particles p = bodies.view();
      std::vector<int> who(p.n);
      std::iota(who.begin(), who.end(), 0);
      Places places;
      reader.find(p, who, places);
      ReadGroup group;
      group.cells = {&c, nullptr, nullptr, &eps};
      group.cell_weight = weight;
      reader.load({group});
      const std::array<FixedPoint, 2> scale{FixedPoint(3.0, 200), FixedPoint(1.0, 200)};
      reader.clear_reaction();
      Sum read_side, given, size;
      double lowest = 10, highest = -10;
      reader.at_places(p, who, places, [&](std::size_t q, const auto& place) {
        Four seen;
        reader.at<1>(place, &seen);
        lowest = std::min(lowest, seen[3]), highest = std::max(highest, seen[3]);
        const double heat = 2.5 * std::sin(bodies.tag[q]);
        read_side += heat * seen[0], given += heat, size += std::abs(heat);
        reader.react(place, Four{scale[0].whole(heat), 0, 0, scale[1].whole(0.5)});
      });
      CellField<FineGrid> source(layout.cells(rank_of(comm))), coefficient(source.box());
      reader.collect(scale, weight, {&source, nullptr, nullptr, &coefficient});
      Sum cell_side, received, coefficients;
      for_each(source.box(), [&](int i, int j, int k) {
        cell_side += volume(i, j, k) * source(i, j, k) * c(i, j, k);
        received += volume(i, j, k) * source(i, j, k);
        coefficients += volume(i, j, k) * coefficient(i, j, k);
      });
      const double all_sizes = total(size.value());
      EXPECT_NEAR(total(read_side.value()), total(cell_side.value()), 1e-14 * all_sizes) << int(read);
      EXPECT_NEAR(total(given.value()), total(received.value()), 1e-14 * all_sizes) << int(read);
      EXPECT_NEAR(total(coefficients.value()), 100, 1e-11);
      if (p.n > 0) {
        EXPECT_GE(lowest, 0.5 - 1e-12);
        EXPECT_LE(highest, 0.9 + 1e-12);
        EXPECT_GT(highest - lowest, 0.02);
      }
    }
}

/// A steady force on every particle, in proportion to its volume.
struct Push : ExchangeModel {
  Vec3 per_volume;
  int *gives, *takes;
  Push(const Vec3& f, int* g, int* t) : per_volume(f), gives(g), takes(t) {}
  bool forces() const override { return true; }
  void give(const ExchangeSite& site) override {
    ++*gives;
    EXPECT_EQ(site.places.corners.size() + site.places.node.size(), site.who.size());
  }
  void take(const ExchangeSite& site) override {
    ++*takes;
    for (int i : site.who)
      for (int d = 0; d < 3; ++d)
        site.p.state[i][kPressureForce + d] += sphere_volume(site.p.radius[i]) * per_volume[d];
  }
};

// A fluid too thin for drag: the particles feel the model's force and no other, at every step the same, and the fluid
// receives its opposite.
TEST(ExchangeModels, ForceOfItsOwnActsOnParticlesAndOnTheFluid) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const Vec3 push{3, -2, 5};
  for (Formulation form : {Formulation::kA, Formulation::kB})
    for (bool two_sizes : {false, true}) {
      const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {8, 8, 8}, {true, true, true});
      const Layout layout = make_layout(grid, ranks_of(comm), {2, 2, 2});
      FakeFluid fluid(comm, grid, layout, 1e-9, 1e-12);
      Vec3 received{0, 0, 0};
      fluid.on_advance = [&](double interval, const VoidFractionInTime&, const Interphase& exchange) {
        for (int d = 0; d < 3; ++d) {
          const Array3<double> source = source_of(exchange, d, fluid.own_faces_[d]);
          double sum = 0;
          for_each(source.box(), [&](int i, int j, int k) { sum += source(i, j, k) / 512; });
          received[d] += total(sum) * interval;
        }
      };
      Settings s;
      s.id = "gas", s.fine = {8, 8, 8}, s.ratio = {2, 2, 2}, s.every = 4, s.formulation = form;
      choose(*find_method(kDefaultMethod), 0, s);
      const ParticleRegion r = make_region(grid, comm, 0.1);
      Coupling coupling(comm, s, fluid, r.lo, r.hi, r.reach);
      int gives = 0, takes = 0;
      coupling.add_model(std::make_unique<Push>(push, &gives, &takes));
      Bodies all;
      for (int q = 0; q < 40; ++q)
        all.add({0.5 + 0.49 * std::sin(1.0 + 3 * q), 0.5 + 0.49 * std::cos(2.3 * q), 0.5 + 0.49 * std::sin(0.7 * q)},
                two_sizes && q % 3 == 0 ? 0.03 : 0.04, 5000, {0, 0, 0}, q + 1);
      Bodies bodies = share_of(all, grid, comm);
      Particles p = bodies.view();
      double volume = 0;
      for (int i = 0; i < p.n; ++i) volume += sphere_volume(p.radius[i]);
      volume = total(volume);
      const double dt = 1e-3;
      // In A the fake fluid, which nothing moves, has an undisturbed flow's force of its own.
      const auto forces_are_right = [&] {
        if (form == Formulation::kA) return;
        for (int i = 0; i < p.n; ++i)
          for (int d = 0; d < 3; ++d)
            EXPECT_NEAR(p.f[i][d], sphere_volume(p.radius[i]) * push[d], 1e-8 * std::abs(push[d]));
      };
      coupling.start(p, dt);
      coupling.force(p, dt, false);
      forces_are_right();
      for (int step = 1; step <= 12; ++step) {
        if (step % 4 == 0) coupling.advance(p, 4, dt);
        for (auto& f : bodies.f) f = {0, 0, 0};
        coupling.force(p, dt, true);
        forces_are_right();
        coupling.finish_step(p);
      }
      EXPECT_EQ(gives, 3);
      EXPECT_EQ(takes, 4);
      // Half a step's impulse of set-up, and the steps up to the last coupling.
      for (int d = 0; d < 3 && form == Formulation::kB; ++d)
        EXPECT_NEAR(received[d], -volume * push[d] * dt * 11.5, 1e-6 * std::abs(volume * push[d] * dt * 11.5)) << d;
      EXPECT_LT(coupling.report().momentum_error, 1e-12);
    }
}

}  // namespace
}  // namespace twogrid_test
