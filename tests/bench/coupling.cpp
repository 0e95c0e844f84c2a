// Cost of the coupling's own work, a particle: spheres of 1.2 mm at random, 40 % solids in the lower quarter of the box
// of tests/bench/common_case.py, a fluid that costs nothing. CPU time in nanoseconds a particle.
//
//   coupling_bench                      counters: ns_deposit (volume onto the nodes, down to the fine grid),
//                                       ns_map (map, react, kick, read, drag law), ns_all: a coupling, a particle
//   coupling_bench --benchmark_filter=force     ns_particle: drag and buoyancy at a DEM step
#include "coupling/coupling.h"

#include <benchmark/benchmark.h>
#include <mpi.h>

#include <cmath>
#include <random>

#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kDemStep = 1e-5, kDiameter = 1.2e-3, kDensity = 1000;
constexpr int kEvery = 10;

struct Method {
  const char* name;
  Deposit deposit;
  Prolong prolong;
  Read read;
};
constexpr Method kMethods[] = {
    {"centroid_constant_cell", Deposit::kCentroid, Prolong::kConstant, Read::kCell},
    {"trilinear_constant_cell", Deposit::kTrilinear, Prolong::kConstant, Read::kCell},
    {"trilinear_linear_trilinear", Deposit::kTrilinear, Prolong::kLinear, Read::kTrilinear},
    {"exact_linear_trilinear", Deposit::kExact, Prolong::kLinear, Read::kTrilinear},
};

/// The bed, `wide` times as wide as the common case: 9240 particles and 2250 nodes each time.
struct Bed {
  FineGrid grid;
  FakeFluid fluid;
  Bodies bodies;
  Coupling coupling;

  static Settings settings(const Method& method) {
    Settings s;
    s.id = "gas";
    s.drag = "ergun/wenyu";
    s.deposit = method.deposit;
    s.prolong = method.prolong;
    s.read = method.read;
    s.every = kEvery;
    return s;
  }

  Bed(const Method& method, int wide)
      : grid(make_grid({0, 0, 0}, {0.044 * wide, 0.010, 0.150}, {15 * wide, 3, 50}, {false, false, false})),
        fluid(MPI_COMM_WORLD, grid, make_layout(grid, 1, {1, 1, 1}), 1.2, 1.8e-5),
        coupling(MPI_COMM_WORLD, settings(method), fluid, {0, 0, 0}, {0.044 * wide, 0.010, 0.150}, 2e-4) {
    std::mt19937 random(1);
    const auto within = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
    for (int q = 0; q < 9240 * wide; ++q)
      bodies.add({within(0, 0.044 * wide), within(0, 0.010), within(0, 0.0475)}, 0.5 * kDiameter, kDensity,
                 {within(-0.3, 0.3), within(-0.3, 0.3), within(-0.3, 0.3)}, q + 1);
    fluid.open_side(2, false);
    fluid.open_side(2, true);
    fluid.set(fluid.u_, [](int d, const Vec3& x) { return (d == 2 ? 1.5 : 0.0) + 0.3 * std::sin(300 * x[0] + d); });
    fluid.mean_ = fluid.u_;
    Particles p = bodies.view();
    coupling.start(p, kDemStep);
    coupling.force(p, kDemStep, false);
  }
};

void coupling(benchmark::State& state, const Method& method) {
  Bed bed(method, int(state.range(0)));
  Particles p = bed.bodies.view();
  const Shares before = bed.coupling.shares();
  for (auto _ : state) bed.coupling.advance(p, kEvery, kDemStep);
  const Shares after = bed.coupling.shares();
  const double per = 1e9 / (double(p.n) * double(state.iterations()));
  state.counters["ns_deposit"] = (after.deposit - before.deposit) * per;
  state.counters["ns_map"] = (after.map - before.map) * per;
  state.counters["ns_all"] = benchmark::Counter(
      double(p.n) * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void force(benchmark::State& state) {
  Bed bed(kMethods[1], int(state.range(0)));
  Particles p = bed.bodies.view();
  p.watched = false;
  for (auto _ : state) bed.coupling.force(p, kDemStep);
  state.counters["ns_particle"] = benchmark::Counter(
      double(p.n) * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

}  // namespace
}  // namespace twogrid_test

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  for (const auto& method : twogrid_test::kMethods)
    benchmark::RegisterBenchmark((std::string("coupling/") + method.name).c_str(), twogrid_test::coupling, method)
        ->Arg(1)
        ->Arg(10);
  benchmark::RegisterBenchmark("force", twogrid_test::force)->Arg(1)->Arg(10);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  MPI_Finalize();
}
