// What must not change: momentum but by forces, volume in a closed box, and a given flow rate.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdint>
#include <string>

#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"
#include "tests/verification/formulation_a.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A PETSc option for the life of the object.
struct Option {
  std::string name;
  Option(const std::string& n, const std::string& value) : name(n) {
    PetscOptionsSetValue(nullptr, n.c_str(), value.c_str());
  }
  ~Option() { PetscOptionsClearValue(nullptr, name.c_str()); }
};

/// The same numbers on every layout: a hash of the indices, in [0, 1).
double noise(int i, int j, int k, int seed) {
  std::uint64_t h = std::uint64_t(i + 1000) * 73856093u ^ std::uint64_t(j + 1000) * 19349663u ^
                    std::uint64_t(k + 1000) * 83492791u ^ std::uint64_t(seed) * 2654435761u;
  h ^= h >> 13, h *= 0x9E3779B97F4A7C15ull, h ^= h >> 29, h *= 0xBF58476D1CE4E5B9ull, h ^= h >> 32;
  return double(h >> 11) / 9007199254740992.0;
}

}  // namespace

TEST(Conservation, MomentumOfAPeriodicBoxChangesByForcesAlone) {
  // Without it, drag, the share of grad p or the transport with a moving eps could make or lose momentum.
  Option tight("-fluid_momentum_ksp_rtol", "1e-14");
  for (bool a : {false, true})
    for (bool implicit : {false, true})
      for (Convection scheme : {Convection::kVanLeer, Convection::kCentral}) {
        FluidSettings s;
        s.density = 1.2, s.viscosity = 0.02, s.convection = scheme, s.pressure_rtol = 1e-13, s.dt = 1e9;
        s.implicit_viscosity = implicit ? Choice::kOn : Choice::kOff;
        s.initial_velocity = {0.5, -0.3, 0.2};
        s.pressure_gradient = {0.3, 0, -0.1};
        const Int3 n{10, 8, 6};
        CfdBox box({graded_nodes(0, 1, n[0], 1.1, true), uniform(0, 0.8, n[1]), uniform(0, 0.6, n[2])},
                   {true, true, true}, s);
        auto wrap = [&](int i, int d) { return ((i % n[d]) + n[d]) % n[d]; };
        auto deposit = [&](CellField<FineGrid>& e, int step) {
          double sum[2] = {0, 0};
          for_each(e.box(), [&](int i, int j, int k) {
            const int p = wrap(i, 0), q = wrap(j, 1), r = wrap(k, 2);
            e(i, j, k) = 0.6 + 0.1 * (noise(p, q, r, 1) - 0.5) + 0.02 * step * (noise(p, q, r, 2) - 0.5);
          });
          // The same solid volume at every step.
          for_each(box.own(), [&](int i, int j, int k) {
            sum[0] += e(i, j, k) * box.grid.volume(i, j, k), sum[1] += box.grid.volume(i, j, k);
          });
          const double shift = 0.6 - box.sum(sum[0]) / box.sum(sum[1]);
          for (std::size_t m = 0; m < e.size(); ++m) e.data()[m] += shift;
        };
        deposit(box.eps_begin, 0);
        box.fluid->start(box.eps_begin);
        box.fluid->keep_pressure_gradient();
        FieldExchange exchange;
        exchange.source = exchange.beta = box.face_field();
        FormulationA particles(box);
        double worst = 0, most = 0;
        const double dt = 0.02;
        for (int step = 1; step <= 6; ++step) {
          deposit(box.eps_end, step);
          for (int d = 0; d < 3; ++d)
            for_each(box.faces(d), [&](int i, int j, int k) {
              exchange.beta[d](i, j, k) = 40 * noise(i, j, k, 10 * step + d);
              exchange.source[d](i, j, k) = 20 * (noise(i, j, k, 10 * step + d + 3) - 0.5);
            });
          Vec3 before = box.fluid->total_momentum(), pending = box.fluid->pending_momentum();
          // A: drag that pulls along particles at rest, and the particles' pressure force.
          const FieldExchange& felt = a ? particles.exchange(exchange.beta, {}, exchange.source) : exchange;
          box.step(dt, felt);
          if (a) particles.read();
          const Vec3 after = box.fluid->total_momentum(), still = box.fluid->pending_momentum();
          box.eps_begin = box.eps_end;
          if (step < 3) continue;  // BDF2 with a constant step
          for (int d = 0; d < 3; ++d) {
            double force = 0, size = 0;
            for_each(box.faces(d), [&](int i, int j, int k) {
              const double V = box.fluid->measures().volume(d, i, j, k);
              const double drag = felt.beta[d](i, j, k) * box.fluid->mean_velocity()[d](i, j, k);
              const double push = box.fluid->mean_pressure_gradient()[d](i, j, k);
              force += V * (felt.source[d](i, j, k) - drag - push);
              size += V * (std::abs(felt.source[d](i, j, k)) + std::abs(drag) + std::abs(push));
            });
            const double change = after[d] + still[d] - before[d] - pending[d];
            worst = std::max(worst, std::abs(change - box.sum(force) * dt));
            most = std::max(most, box.sum(size) * dt);
          }
        }
        report("momentum, periodic box, %s, %s viscosity, %s: unexplained %.1e of the impulses\n", a ? "A" : "B",
               implicit ? "implicit" : "explicit", scheme == Convection::kCentral ? "central" : "van Leer",
               worst / most);
        EXPECT_LT(worst, 1e-12 * most);
      }
}

TEST(Conservation, ClosedBoxNeedsNoOutlet) {
  // Settling in a closed box: eps changes, no face lets fluid out, p is defined up to a constant.
  FluidSettings s;
  s.density = 1.2, s.viscosity = 0.01, s.pressure_rtol = 1e-11;
  for (int side = 0; side < 6; ++side) s.side[side] = {condition(BoundaryKind::kNoSlip)};
  CfdBox box({uniform(0, 1, 7), uniform(0, 1, 6), uniform(0, 1, 9)}, {false, false, false}, s);
  auto eps = [](double t) -> Function {
    return [t](double x, double y, double z) {
      return 0.6 + 0.2 * std::cos(kPi * x) * std::cos(kPi * z) * std::cos(t) + 0.05 * std::cos(2 * kPi * y);
    };
  };
  box.set(box.eps_begin, eps(0));
  box.fluid->start(box.eps_begin);
  double divergence = 0;
  for (int k = 1; k <= 5; ++k) {
    box.set(box.eps_end, eps(0.1 * k));
    divergence = std::max(divergence, box.step(0.1).divergence_error);
    box.eps_begin = box.eps_end;
  }
  double mean = 0, size = 0;
  for_each(box.own(), [&](int i, int j, int k) {
    mean += box.fluid->pressure()(i, j, k) * box.grid.volume(i, j, k);
    size = std::max(size, std::abs(box.fluid->pressure()(i, j, k)));
  });
  report("closed box: continuity %.1e, mean p %.1e of the largest\n", divergence, box.sum(mean) / box.largest(size));
  EXPECT_LT(divergence, 1e-9);
  EXPECT_GT(box.largest(size), 0);
}

TEST(FlowRate, IsHeldToRoundOff) {
  for (int d : {0, 1, 2})
    for (bool walls : {true, false}) {
      FluidSettings s;
      s.density = 1.2, s.viscosity = 0.05, s.pressure_rtol = 1e-13, s.dt = 1e9;
      s.flow_rate_set[d] = true;
      s.flow_rate[d] = 0.8;
      const int e = (d + 1) % 3;
      std::array<bool, 3> periodic{true, true, true};
      if (walls) {
        periodic[e] = false;
        s.side[2 * e] = s.side[2 * e + 1] = {condition(BoundaryKind::kNoSlip)};
      }
      std::array<std::vector<double>, 3> nodes{uniform(0, 1, 6), uniform(0, 1, 6), uniform(0, 1, 6)};
      nodes[d] = uniform(0, 1, 8);
      CfdBox box(nodes, periodic, s);
      FieldExchange exchange;
      Interphase without_drag;
      exchange.particle_flux[d] = without_drag.particle_flux[d] = 0.1;
      exchange.beta = box.face_field();
      for (int c = 0; c < 3; ++c)
        for_each(box.faces(c), [&](int i, int j, int k) { exchange.beta[c](i, j, k) = 5 * noise(i, j, k, c); });
      // Uniform eps without drag too, where nothing but round-off answers a unit gradient.
      double worst = 0;
      for (bool bare : {true, false}) {
        if (!bare)
          box.set(box.eps_begin, [&](double x, double y, double z) {
            return 0.6 + 0.2 * std::sin(2 * kPi * x) * std::cos(2 * kPi * y) + 0.1 * std::sin(2 * kPi * z);
          });
        box.eps_end = box.eps_begin;
        box.fluid->start(box.eps_begin);
        for (int k = 0; k < 6; ++k) {
          box.step(0.01, bare ? without_drag : exchange);
          double flow = 0, volume = 0;
          for_each(box.faces(d), [&](int i, int j, int k2) {
            const double V = box.fluid->measures().volume(d, i, j, k2);
            flow += box.fluid->flux(d, i, j, k2) * V, volume += V;
          });
          worst = std::max(worst, std::abs(box.sum(flow) / box.sum(volume) - 0.7));
        }
      }
      report("flow rate along %d, %s: off by %.1e\n", d, walls ? "no-slip walls" : "periodic", worst / 0.8);
      EXPECT_LT(worst, 1e-12);
    }
}

TEST(FlowRate, IsHeldBesideInletAndOutlet) {
  // Across the held direction fluid comes in and goes out, and the void fraction changes. Without this test the answer
  // to a mean gradient could leave through the outlet (its ghost is the face itself, at half the distance), or the
  // correction of the flow rate could spoil the continuity that has just been solved.
  enum { kThrough, kTwoOutlets, kOneSide };
  for (int d : {0, 1, 2})
    for (int sides : {kThrough, kTwoOutlets, kOneSide})
      for (Choice implicit : {Choice::kOff, Choice::kOn}) {
        FluidSettings s;
        s.density = 1.2, s.viscosity = 0.05, s.pressure_rtol = 1e-13, s.dt = 1e9, s.implicit_viscosity = implicit;
        s.flow_rate_set[d] = true;
        s.flow_rate[d] = 0.8;
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        std::array<bool, 3> periodic{false, false, false};
        periodic[d] = true;
        Vec3 in{0, 0, 0};
        in[e] = 0.4, in[d] = 0.3;
        const auto wall = condition(BoundaryKind::kNoSlip), inlet = condition(BoundaryKind::kInlet, in),
                   outlet = condition(BoundaryKind::kPressure, {0, 0, 0}, 2.0);
        s.side[2 * e] = {sides == kThrough ? inlet : sides == kTwoOutlets ? outlet : wall};
        s.side[2 * e + 1] = {outlet};
        s.side[2 * f] = s.side[2 * f + 1] = {wall};
        std::array<std::vector<double>, 3> nodes;
        nodes[d] = graded_nodes(0, 1, 8, 1.05), nodes[e] = graded_nodes(0, 1, 7, 1.1), nodes[f] = uniform(0, 1, 6);
        CfdBox box(nodes, periodic, s);
        auto eps = [&](double t) -> Function {
          return [t, d, e](double x, double y, double z) {
            const Vec3 q{x, y, z};
            return 0.6 + 0.2 * std::sin(2 * kPi * (q[d] - t)) * std::cos(2 * kPi * q[e]) + 0.1 * std::sin(3 * t);
          };
        };
        FieldExchange exchange;
        exchange.particle_flux[d] = 0.1;
        exchange.beta = exchange.source = box.face_field();
        for (int c = 0; c < 3; ++c)
          for_each(box.faces(c), [&](int i, int j, int k) {
            exchange.beta[c](i, j, k) = 5 * noise(i, j, k, c), exchange.source[c](i, j, k) = noise(i, j, k, c + 3);
          });
        box.set(box.eps_begin, eps(0));
        box.fluid->start(box.eps_begin);
        const double dt = 0.01;
        double worst = 0, lost = 0, divergence = 0, through = 0;
        for (int step = 1; step <= 8; ++step) {
          box.set(box.eps_end, eps(step * dt));
          const FluidReport r = box.step(dt, exchange);
          box.eps_begin = box.eps_end;
          double flow = 0, volume = 0;
          for_each(box.faces(d), [&](int i, int j, int k) {
            const double V = box.fluid->measures().volume(d, i, j, k);
            flow += box.fluid->flux(d, i, j, k) * V, volume += V;
          });
          worst = std::max(worst, std::abs(box.sum(flow) / box.sum(volume) - 0.7));
          lost = std::max(lost, std::abs(r.inflow - r.outflow + r.displaced));
          through = std::max(through, r.inflow + r.outflow);
          divergence = std::max(divergence, r.divergence_error);
        }
        const char* name = sides == kThrough ? "inlet and outlet" : sides == kTwoOutlets ? "two outlets" : "one outlet";
        report("flow rate along %d, %s, %s viscosity: off by %.1e, volume lost %.1e of %.2f, continuity %.1e\n", d,
               name, implicit == Choice::kOn ? "implicit" : "explicit", worst / 0.8, lost, through, divergence);
        EXPECT_LT(worst, 1e-12);
        EXPECT_LT(lost, 1e-11);
        EXPECT_LT(divergence, 1e-10);
        EXPECT_GT(through, 0.01);
      }
}

TEST(FlowRate, OfAChannelOpenAboveIsThatOfItsMeanGradient) {
  // Developed flow along x between a no-slip wall and an open side, of viscosity mu and height H = 1: u = G/(2 mu)
  // (z^2 - 2 z), of mean -G/(3 mu), on cells of height h by the factor 1 + h^2/2 more. What holds the flow rate must
  // find this G; it would not if the open side took part of the mean gradient.
  FluidSettings s;
  s.density = 1.2, s.viscosity = 0.5, s.pressure_rtol = 1e-12, s.dt = 1e9;
  s.flow_rate_set[0] = true, s.flow_rate[0] = 0.3, s.initial_velocity = {0.3, 0, 0};
  s.side[kYlo] = s.side[kYhi] = {condition(BoundaryKind::kSlip)};
  s.side[kZlo] = {condition(BoundaryKind::kNoSlip)};
  s.side[kZhi] = {condition(BoundaryKind::kPressure)};
  const int n = 20;
  CfdBox box({uniform(0, 0.4, 4), uniform(0, 0.1, 1), uniform(0, 1, n)}, {true, false, false}, s);
  box.fluid->keep_pressure_gradient();
  for (int k = 0; k < 400; ++k) box.step(0.02);
  double gradient = 0, volume = 0;
  for_each(box.faces(0), [&](int i, int j, int k) {
    const double V = box.fluid->measures().volume(0, i, j, k);
    gradient += box.fluid->mean_pressure_gradient()[0](i, j, k) * V, volume += V;
  });
  gradient = box.sum(gradient) / box.sum(volume);
  const double h = 1.0 / n, wanted = -3 * 0.5 * 0.3 / (1 + 0.5 * h * h);
  report("flow rate of a film: mean gradient %.9f, wanted %.9f Pa/m\n", gradient, wanted);
  EXPECT_NEAR(gradient, wanted, 1e-7);
}
