// What must not change: momentum but by forces, a given flow rate, and the flow when axes or ranks are exchanged.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdint>
#include <string>

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
        Interphase exchange;
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
          const Interphase& felt = a ? particles.exchange(exchange.beta, {}, exchange.source) : exchange;
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
      Interphase exchange;
      exchange.particle_flux[d] = 0.1;
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
          box.step(0.01, bare ? Interphase{exchange.source, {}, false, exchange.particle_flux} : exchange);
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
        Interphase exchange;
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

TEST(GapFriction, IsThatOfAHeleShawCell) {
  for (int thin : {0, 1, 2}) {
    const int along = (thin + 1) % 3, across = (thin + 2) % 3;
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.3, s.gap_friction = true, s.dt = 1e9;
    s.pressure_gradient[along] = -5;
    s.side[2 * thin] = s.side[2 * thin + 1] = {condition(BoundaryKind::kSlip)};
    std::array<bool, 3> periodic{true, true, true};
    periodic[thin] = false;
    const double W = 0.2;
    std::array<std::vector<double>, 3> nodes;
    nodes[thin] = uniform(0, W, 1), nodes[along] = uniform(0, 1, 4), nodes[across] = uniform(0, 1, 4);
    CfdBox box(nodes, periodic, s);
    for (int k = 0; k < 60; ++k) box.step(0.02);
    const double wanted = 5 * W * W / (12 * 0.3);
    const double error = box.face_error(along, [&](double, double, double) { return wanted; });
    if (thin == 0) report("gap friction: mean velocity off by %.1e\n", error / wanted);
    EXPECT_LT(error, 1e-9 * wanted);
  }
}

TEST(ImplicitViscosity, ChannelStartUpAtLargeViscousNumbers) {
  // Flow from rest between walls 1 apart under a constant gradient (Batchelor 1967, section 4.3):
  // u = G/(2 mu) y(1-y) - 4 G/(mu pi^3) sum over odd m of sin(m pi y) exp(-m^2 pi^2 nu t)/m^3.
  for (double dt : {0.1, 0.005}) {
    const int n = 32;
    const double nu = 1;
    FluidSettings s;
    s.density = 2, s.viscosity = nu * s.density, s.dt = dt;
    s.pressure_gradient[0] = -2 * s.viscosity;
    s.side[kYlo] = s.side[kYhi] = {condition(BoundaryKind::kNoSlip)};
    s.side[kZlo] = s.side[kZhi] = {condition(BoundaryKind::kSlip)};
    CfdBox box({uniform(0, 1, 2), uniform(0, 1, n), uniform(0, 1, 1)}, {true, false, false}, s);
    double worst = 0, t = 0;
    for (int k = 0; t < 1 - 1e-9; ++k) {
      box.step(dt);
      t += dt;
      const double e = box.face_error(0, [&](double, double y, double) {
        double u = y * (1 - y);
        for (int m = 1; m < 40; m += 2)
          u -= 8 / (kPi * kPi * kPi) * std::sin(m * kPi * y) * std::exp(-m * m * kPi * kPi * nu * t) / (m * m * m);
        return u;
      });
      worst = std::max(worst, e / 0.25);
      if (t > 1 - 1e-9) {
        report("channel start-up, viscous number nu dt/h2 = %.0f: error %.1e at most, %.1e at the end\n",
               nu * dt * n * n, worst, e / 0.25);
        EXPECT_LT(e / 0.25, 2e-3);
      }
    }
    EXPECT_LT(worst, dt > 0.05 ? 0.15 : 0.01);
  }
}

TEST(StretchedGrid, VortexInFlatCells) {
  // psi = sin(2 pi x/L) sin(2 pi y/H) decays without changing its shape, also in cells of aspect 20 or graded ones.
  auto error = [](int n, double H, double ratio) {
    FluidSettings s;
    s.density = 1, s.viscosity = 0.002, s.convection = Convection::kCentral, s.pressure_rtol = 1e-8;
    s.implicit_viscosity = Choice::kOn;
    const double kx = 2 * kPi, ky = 2 * kPi / H, rate = s.viscosity * (kx * kx + ky * ky), T = 0.25 / rate;
    const int steps = 6 * n;
    s.dt = T / steps;
    const double r = std::pow(ratio, 16.0 / n);
    CfdBox box({graded_nodes(0, 1, n, r, true), graded_nodes(0, H, n, r, true), uniform(0, 1.0 / n, 1)},
               {true, true, true}, s);
    const double amplitude = 0.3 * H / T;
    auto u = [&](double t) -> Function {
      return [=](double x, double y, double) {
        return amplitude * std::sin(kx * x) * std::cos(ky * y) * std::exp(-rate * t);
      };
    };
    auto v = [&](double t) -> Function {
      return [=](double x, double y, double) {
        return -amplitude * kx / ky * std::cos(kx * x) * std::sin(ky * y) * std::exp(-rate * t);
      };
    };
    auto now = box.face_field(), old = box.face_field();
    box.set_faces(0, now[0], u(0)), box.set_faces(1, now[1], v(0));
    box.set_faces(0, old[0], u(-s.dt)), box.set_faces(1, old[1], v(-s.dt));
    CellField<FineGrid> p(box.eps_begin.box());
    box.set(p, [&](double x, double y, double) {
      return 0.25 * amplitude * amplitude * (std::cos(2 * kx * x) + kx * kx / (ky * ky) * std::cos(2 * ky * y));
    });
    box.fluid->set_state(0, now, p, box.eps_begin, s.dt, old, box.eps_begin);
    for (int k = 0; k < steps; ++k) box.step(s.dt);
    return box.face_error(0, u(T)) / amplitude;
  };
  const double set[5][2] = {{1, 1.1}, {1, 1.2}, {1, 1.3}, {0.05, 1.0}, {0.05, 1.2}};
  for (const auto& x : set) {
    const double e1 = error(24, x[0], x[1]), e2 = error(48, x[0], x[1]);
    report("vortex, box 1 x %g, stretch %g: error %.2e %.2e, order %.2f\n", x[0], x[1], e1, e2, std::log2(e1 / e2));
    EXPECT_GT(std::log2(e1 / e2), 1.9);
  }
}

namespace {

/// A jet into a bed that varies in space and time, with drag. The flow's own axes 0, 1, 2 lie along the solver's
/// directions turn, turn + 1, turn + 2; mirrored: flow axis 0 runs the other way.
struct Turned {
  std::array<std::vector<double>, 3> u;  // along the flow's axes, in the flow's own order
  std::vector<double> p;
};

Turned jet(int turn, bool mirrored, MPI_Comm comm, const CfdBox::Cuts* cuts = nullptr) {
  const Int3 n{8, 6, 10};  // along the flow's axes
  const std::array<double, 3> length{0.01, 0.008, 0.02};
  std::array<int, 3> dir{turn, (turn + 1) % 3, (turn + 2) % 3};
  FluidSettings s;
  s.density = 1.2, s.viscosity = 1e-4, s.pressure_rtol = 1e-12, s.dt = 1e9;
  std::array<std::vector<double>, 3> nodes;
  for (int a = 0; a < 3; ++a) nodes[dir[a]] = uniform(0, length[a], n[a]);
  s.side[2 * dir[0]] = s.side[2 * dir[0] + 1] = {condition(BoundaryKind::kNoSlip)};
  s.side[2 * dir[1]] = s.side[2 * dir[1] + 1] = {condition(BoundaryKind::kSlip)};
  s.side[2 * dir[2] + 1] = {condition(BoundaryKind::kPressure)};
  auto along = [&](int d) { return (d - turn + 3) % 3; };  // flow axis of direction d
  auto flow_at = [&, mirrored](const Vec3& x) {
    Vec3 q{x[dir[0]], x[dir[1]], x[dir[2]]};
    if (mirrored) q[0] = length[0] - q[0];
    return q;
  };
  BoundaryCondition patch = condition(BoundaryKind::kInlet);
  patch.name = "jet";
  patch.shape.kind = PatchShape::Kind::kRegion;
  patch.shape.inside = [flow_at](const Vec3& x) {
    const Vec3 q = flow_at(x);
    return q[0] > 0.0025 && q[0] < 0.005 && q[1] > 0.0027 && q[1] < 0.0055;
  };
  patch.velocity[dir[2]] = 10;
  s.side[2 * dir[2]] = {condition(BoundaryKind::kNoSlip), patch};
  CfdBox box(nodes, {false, false, false}, s, comm, cuts);
  auto eps = [&](double t) -> Function {
    return [&, t](double x, double y, double z) {
      const Vec3 q = flow_at({x, y, z});
      return 0.6 + 0.2 * std::sin(400 * q[0] + 300 * t) * std::cos(500 * q[1]) * std::sin(200 * q[2]);
    };
  };
  box.set(box.eps_begin, eps(0));
  box.fluid->start(box.eps_begin);
  Interphase exchange;
  exchange.beta = box.face_field();
  FormulationA particles(box);
  const double dt = 2e-5;
  for (int k = 1; k <= 10; ++k) {
    box.set(box.eps_end, eps(k * dt));
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d), [&](int i, int j, int l) {
        const Vec3 q = flow_at(box.face(d, i, j, l));
        exchange.beta[d](i, j, l) = 2e4 * (1 + std::sin(300 * q[2] + 100 * q[0]));
      });
    box.step(dt, particles.exchange(exchange.beta, {}, {}));
    particles.read();
    box.eps_begin = box.eps_end;
  }
  Turned result;
  const std::size_t count = std::size_t(n[0] + 1) * (n[1] + 1) * (n[2] + 1);
  const auto p = box.gathered(box.fluid->pressure());
  result.p.assign(count, 0.0);
  for (auto& c : result.u) c.assign(count, 0.0);
  for (int d = 0; d < 3; ++d) {
    const int a = along(d);
    const auto u = box.gathered(d, box.fluid->velocity()[d]);
    for (int k = 0; k < n[2] + (a == 2); ++k)
      for (int j = 0; j < n[1] + (a == 1); ++j)
        for (int i = 0; i < n[0] + (a == 0); ++i) {
          Int3 q;
          q[dir[0]] = mirrored ? n[0] - 1 + (a == 0) - i : i;
          q[dir[1]] = j, q[dir[2]] = k;
          const std::size_t m = i + (n[0] + 1) * (j + std::size_t(n[1] + 1) * k);
          result.u[a][m] = (mirrored && a == 0 ? -1 : 1) * u[box.at(q[0], q[1], q[2])];
          if (a == 0 && i < n[0]) {
            Int3 c = q;
            c[dir[0]] = mirrored ? n[0] - 1 - i : i;
            result.p[m] = p[box.at(c[0], c[1], c[2])];
          }
        }
  }
  return result;
}

double difference(const Turned& x, const Turned& y) {
  double most = 0, size = 0, p_most = 0, p_size = 0;
  for (int d = 0; d < 3; ++d)
    for (std::size_t m = 0; m < x.u[d].size(); ++m) {
      most = std::max(most, std::abs(x.u[d][m] - y.u[d][m]));
      size = std::max(size, std::abs(x.u[d][m]));
    }
  for (std::size_t m = 0; m < x.p.size(); ++m) {
    p_most = std::max(p_most, std::abs(x.p[m] - y.p[m]));
    p_size = std::max(p_size, std::abs(x.p[m]));
  }
  return std::max(most / size, p_most / p_size);
}

}  // namespace

TEST(Symmetry, SameFlowAlongAllAxesAndMirrored) {
  const Turned base = jet(0, false, MPI_COMM_WORLD);
  for (int turn : {0, 1, 2})
    for (bool mirrored : {false, true}) {
      const double e = difference(base, jet(turn, mirrored, MPI_COMM_WORLD));
      report("jet turned by %d%s: differs by %.1e\n", turn, mirrored ? ", mirrored" : "", e);
      EXPECT_LT(e, 1e-9);
    }
}

TEST(Ranks, SameFlowOnOneAndAll) {
  const double e = difference(jet(0, false, MPI_COMM_SELF), jet(0, false, MPI_COMM_WORLD));
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  report("jet on 1 and on %d ranks: differs by %.1e\n", ranks, e);
  EXPECT_LT(e, 1e-9);
}

TEST(Ranks, SameFlowBesideRanksOneCellThick) {
  // A halo of two reaches over such a rank to the ghosts beyond a side, which no rank owns. Without the test they may
  // stay as they were, and only flow towards the inside of the domain, near a wall, would show it.
  int ranks;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const Turned alone = jet(0, false, MPI_COMM_SELF);
  const Int3 n{8, 6, 10};
  for (int d = 0; d < 3; ++d)
    for (bool high : {false, true}) {
      if (ranks > n[d]) continue;
      CfdBox::Cuts cuts;
      for (int e = 0; e < 3; ++e) {
        cuts[e] = {0};
        for (int a = 1; e == d && a < ranks; ++a) cuts[e].push_back(high ? n[e] - ranks + a : a);
        cuts[e].push_back(n[e]);
      }
      const double e = difference(alone, jet(0, false, MPI_COMM_WORLD, &cuts));
      report("jet, ranks one cell thick at the %s side in %c: differs by %.1e\n", high ? "high" : "low", "xyz"[d], e);
      EXPECT_LT(e, 1e-9);
    }
}
