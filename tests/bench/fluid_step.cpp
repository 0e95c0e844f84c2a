// Cost of the fluid step and of its pressure solve on a made-up bubbling bed: voids of eps near 1 rise at 0.5 m/s
// through a bed of eps = 0.42, freeboard above; drag of Ergun at the superficial 0.9 m/s, d = 1.2 mm, air; inlet below,
// outlet on top, walls around. Figures are CPU time of the thread, in nanoseconds a cell and step; the fields of the
// next interval are made off the clock.
//
//   fluid_bench --benchmark_filter=step        whole step: small (15 x 3 x 50), 50k, 400k, and one cell deep
//   fluid_bench --benchmark_filter=pressure    set-up and solve of the pressure equation, first guess zero
//   counters: ns_cell; iterations a step; bytes a cell (what making the solver and its first steps allocate)
#include <benchmark/benchmark.h>
#include <malloc.h>
#include <mpi.h>
#include <petscsys.h>
#include <time.h>

#include <cmath>
#include <memory>

#include "cfd/fluid_solver.h"
#include "cfd/pressure/pressure_solver.h"
#include "tests/field_exchange.h"

namespace twogrid {
namespace {

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// Memory that the process holds by malloc, bytes.
double allocated() {
  const auto m = mallinfo2();
  return double(m.uordblks) + double(m.hblkhd);
}

constexpr double kWidth = 0.044, kHeight = 0.146, kInlet = 0.9, kDensity = 1.2, kViscosity = 1.8e-5, kDiameter = 1.2e-3;

double smooth_step(double x) {
  return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x);
}

double void_fraction(double x, double y, double z, double t) {
  const double bed = 0.42 + 0.58 * smooth_step((z - 0.09) / 0.01);
  double bubble = 0;
  const double centre[4][4] = {{0.012, 0.004, 0.01, 0.007},
                               {0.03, 0.006, 0.04, 0.009},
                               {0.018, 0.002, 0.065, 0.008},
                               {0.036, 0.005, 0.075, 0.006}};
  for (const auto& c : centre) {
    const double r =
        std::sqrt((x - c[0]) * (x - c[0]) + (y - c[1]) * (y - c[1]) + (z - c[2] - 0.5 * t) * (z - c[2] - 0.5 * t));
    bubble = std::max(bubble, 1 - smooth_step((r - 0.7 * c[3]) / (0.6 * c[3])));
  }
  // Particles arranged at random: what centroid deposition onto a particle grid leaves.
  const double grain = 0.03 * std::sin(1500 * x + 1) * std::sin(1300 * z + 2) * std::sin(1700 * y + 100 * t);
  return std::min(1.0, std::max(0.4, bed + (1 - bed) * bubble + (1 - bed) * (1 - bubble) * grain));
}

double drag(double eps) {
  const double s = 1 - eps, slip = kInlet / eps;
  return 150 * s * s * kViscosity / (eps * kDiameter * kDiameter) + 1.75 * s * kDensity * slip / kDiameter;
}

/// The bed, its fluid and the exchange, on one rank.
struct Bed {
  FineGrid grid;
  Layout layout;
  std::unique_ptr<FluidSolver> fluid;
  CellField<FineGrid> begin, end, slope_begin, rate;
  FieldExchange exchange;
  double interval, time = 0, bytes = 0;

  Bed(const Int3& n, double dt) : interval(dt) {
    const double h = kWidth / n[0];
    grid.axis[0] = Axis(graded_nodes(0, kWidth, n[0]), false);
    grid.axis[1] = Axis(graded_nodes(0, h * n[1], n[1]), false);
    grid.axis[2] = Axis(graded_nodes(0, kHeight, n[2]), false);
    layout = Layout(grid, {std::vector<int>{0, n[0]}, {0, n[1]}, {0, n[2]}});
    FluidSettings s;
    s.density = kDensity, s.viscosity = kViscosity;
    auto side = [](BoundaryKind kind) {
      BoundaryCondition c;
      c.kind = kind;
      return std::vector<BoundaryCondition>{c};
    };
    s.side[kXlo] = s.side[kXhi] = side(BoundaryKind::kNoSlip);
    s.side[kYlo] = s.side[kYhi] = side(BoundaryKind::kSlip);
    s.side[kZlo] = side(BoundaryKind::kInlet), s.side[kZlo][0].velocity = {0, 0, kInlet};
    s.side[kZhi] = side(BoundaryKind::kPressure);
    s.initial_velocity = {0, 0, kInlet};
    const Box local = layout.cells(0).grown(Fluid::kHalo);
    for (auto* c : {&begin, &end, &slope_begin, &rate}) c->reset(local);
    for (int d = 0; d < 3; ++d)
      exchange.source[d].reset(layout.faces(d, 0)), exchange.beta[d].reset(layout.faces(d, 0));
    set(begin, 0), set_slope(slope_begin, 0), set_slope(rate, -0.5 * interval);
    const double before = allocated();
    fluid = std::make_unique<FluidSolver>(MPI_COMM_WORLD, grid, layout, s);
    fluid->start(begin);
    double unused;
    for (int k = 0; k < 3; ++k) step(unused);
    bytes = allocated() - before;
  }

  void set(CellField<FineGrid>& e, double t) const {
    for_each(e.box(), [&](int i, int j, int k) {
      e(i, j, k) = void_fraction(grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k), t);
    });
  }
  void set_slope(CellField<FineGrid>& s, double t) const {
    CellField<FineGrid> later(s.box());
    set(s, t - 0.5 * interval), set(later, t + 0.5 * interval);
    for (std::size_t m = 0; m < s.size(); ++m) s.data()[m] = (later.data()[m] - s.data()[m]) / interval;
  }

  /// One interval; adds the CPU time that the fluid took.
  FluidReport step(double& seconds) {
    set(end, time + interval);
    for (int d = 0; d < 3; ++d) {
      const std::ptrdiff_t s = end.stride(d);
      for_each(exchange.beta[d].box(), [&](int i, int j, int k) {
        const std::ptrdiff_t m = end.index(i, j, k);
        const double beta = drag(0.5 * (end.data()[m] + end.data()[m - s]));
        exchange.beta[d](i, j, k) = beta;
        exchange.source[d](i, j, k) = d == 2 ? 0.1 * beta : 0.0;
      });
    }
    const double start = cpu_seconds();
    const VoidFractionInTime eps{&begin, &end, &slope_begin, &rate, 0.5};
    const FluidReport r = fluid->advance(interval, eps, exchange);
    seconds += cpu_seconds() - start;
    time += interval;
    for (std::size_t m = 0; m < end.size(); ++m) {
      slope_begin.data()[m] = eps.end_slope(std::ptrdiff_t(m), interval);
      rate.data()[m] = (end.data()[m] - begin.data()[m]) / interval;
    }
    begin.swap(end);
    return r;
  }
};

void step(benchmark::State& state, Int3 n, double dt) {
  Bed bed(n, dt);
  double seconds = 0, iterations = 0, steps = 0, divergence = 0;
  for (auto _ : state) {
    double now = 0;
    const FluidReport r = bed.step(now);
    state.SetIterationTime(now);
    seconds += now;
    iterations += r.pressure_iterations;
    steps += r.steps;
    divergence = std::max(divergence, r.divergence_error);
  }
  const double cells = double(n[0]) * n[1] * n[2];
  state.counters["ns_cell"] = seconds / (cells * steps) * 1e9;
  state.counters["iterations"] = iterations / steps;
  state.counters["bytes_cell"] = bed.bytes / cells;
  state.counters["divergence"] = divergence;
}

void pressure(benchmark::State& state, Int3 n, double dt) {
  FineGrid grid;
  const double h = kWidth / n[0];
  grid.axis[0] = Axis(graded_nodes(0, kWidth, n[0]), false);
  grid.axis[1] = Axis(graded_nodes(0, h * n[1], n[1]), false);
  grid.axis[2] = Axis(graded_nodes(0, kHeight, n[2]), false);
  const Layout layout(grid, {std::vector<int>{0, n[0]}, {0, n[1]}, {0, n[2]}});
  CellField<FineGrid> b(grid.cells()), phi(grid.cells());
  FaceField<FineGrid> g;
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    g[d].reset(layout.faces(d, 0));
    for_each(g[d].box(), [&](int i, int j, int k) {
      const Int3 q{i, j, k};
      const bool edge = q[d] == 0 || q[d] == a.n();
      if (edge && !(d == 2 && k == a.n())) return;
      Vec3 x{grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)};
      x[d] = a.node(q[d]);
      const double eps = void_fraction(x[0], x[1], x[2], 0);
      g[d](i, j, k) = eps / (1.5 * kDensity * eps / dt + drag(eps)) * grid.area(d, i, j, k) /
                      ((edge ? 0.5 : 1) * a.face_width(q[d]));
    });
  }
  // The void fraction's rate of change in a step: what drives the projection.
  for_each(b.box(), [&](int i, int j, int k) {
    const double x = grid.axis[0].centre(i), y = grid.axis[1].centre(j), z = grid.axis[2].centre(k);
    b(i, j, k) = (void_fraction(x, y, z, dt) - void_fraction(x, y, z, 0)) / dt * grid.volume(i, j, k);
  });
  PressureSolver solver(MPI_COMM_WORLD, grid, layout, 1e-6);
  double seconds = 0, solves = 0, set_up = 0;
  int iterations = 0;
  for (auto _ : state) {
    phi.fill(0);
    const double start = cpu_seconds();
    solver.set_operator(g, false);
    const double ready = cpu_seconds();
    iterations = solver.solve(b, phi);
    const double now = cpu_seconds();
    state.SetIterationTime(now - start);
    seconds += now - start, set_up += ready - start;
    ++solves;
  }
  const double cells = double(n[0]) * n[1] * n[2];
  state.counters["ns_cell"] = seconds / (cells * solves) * 1e9;
  state.counters["set_up_ns_cell"] = set_up / (cells * solves) * 1e9;
  state.counters["iterations"] = iterations;
}

#define TWOGRID_BENCH(name, n, dt)                                                      \
  BENCHMARK_CAPTURE(step, name, n, dt)->UseManualTime()->Unit(benchmark::kMicrosecond); \
  BENCHMARK_CAPTURE(pressure, name, n, dt)->UseManualTime()->Unit(benchmark::kMicrosecond)
TWOGRID_BENCH(small, (Int3{15, 3, 50}), 1e-4);
TWOGRID_BENCH(one_deep, (Int3{123, 1, 410}), 5e-5);
TWOGRID_BENCH(50k, (Int3{42, 8, 150}), 1e-4);
TWOGRID_BENCH(400k, (Int3{84, 16, 300}), 5e-5);
#undef TWOGRID_BENCH

}  // namespace
}  // namespace twogrid

int main(int argc, char** argv) {
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  PetscOptionsSetValue(nullptr, "-options_left", "no");
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  PetscFinalize();
}
