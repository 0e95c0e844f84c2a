// Flows whose only cause is a void fraction that varies. Without these, momentum could be carried by another flux than
// that of continuity (a uniform flow would not stay uniform), or a void fraction could push the fluid by itself.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"
#include "tests/verification/formulation_a.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

FluidSettings inviscid(Convection scheme) {
  FluidSettings s;
  s.density = 1.2;
  s.convection = scheme;
  s.pressure_rtol = 1e-13;
  s.dt = 1e9;  // the interval is the step
  return s;
}

/// eps of the next level so that the BDF2 formula and the central flux eps_f U balance in every cell (periodic).
std::vector<double> carried(const Axis& axis, double U, double dt, double r, const std::vector<double>& now,
                            const std::vector<double>& old) {
  const int n = axis.n();
  const double a0 = (1 + 2 * r) / (1 + r), a1 = -(1 + r), a2 = r * r / (1 + r);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b(n);
  for (int i = 0; i < n; ++i) {
    A(i, i) += a0;
    b(i) = -a1 * now[i] - a2 * old[i];
    for (int side : {0, 1}) {  // faces i and i + 1
      const int f = i + side, below = (f - 1 + n) % n, above = f % n;
      const double wb = axis.width(f - 1), wa = axis.width(f), c = (side ? 1 : -1) * U * dt / axis.width(i) / (wb + wa);
      A(i, below) += c * wb;
      A(i, above) += c * wa;
    }
  }
  const Eigen::VectorXd x = A.partialPivLu().solve(b);
  return {x.data(), x.data() + n};
}

}  // namespace

TEST(UniformFlow, CarriesTheVoidFractionOfItsOwnFlux) {
  // Without it, a mismatch between the flux of momentum and that of continuity would pass as "noise of the particles".
  for (Convection scheme : {Convection::kCentral, Convection::kVanLeer})
    for (bool constant_dt : {true, false})
      for (bool drag : {false, true})
        for (int d : {0, 1, 2}) {
          const int n = 24;
          const double U = 0.7;
          std::array<std::vector<double>, 3> nodes{uniform(0, 0.1, 2), uniform(0, 0.1, 2), uniform(0, 0.1, 2)};
          nodes[d] = graded_nodes(0, 1, n, 1.1, true);
          FluidSettings s = inviscid(scheme);
          s.initial_velocity = {0.2, 0.2, 0.2};
          s.initial_velocity[d] = U;
          CfdBox box(nodes, {true, true, true}, s);
          std::vector<double> now(n), old(n);
          for (int i = 0; i < n; ++i) {
            const double x = 2 * kPi * box.grid.axis[d].centre(i);
            now[i] = 0.6 + 0.3 * std::sin(x) + 0.05 * std::cos(3 * x);
          }
          old = now;
          auto put = [&](CellField<FineGrid>& e, const std::vector<double>& v) {
            for_each(e.box(), [&](int i, int j, int k) {
              const Int3 q{i, j, k};
              e(i, j, k) = v[(q[d] + n) % n];
            });
          };
          put(box.eps_begin, now);
          // Not start(): its initial flow is made continuous with eps at rest, here eps moves from the first moment.
          auto u = box.face_field();
          for (int c = 0; c < 3; ++c) u[c].fill(s.initial_velocity[c]);
          box.fluid->set_state(0, u, CellField<FineGrid>(box.eps_begin.box()), box.eps_begin, 0, u, box.eps_begin);
          FieldExchange exchange;
          if (drag) {
            exchange.beta = exchange.source = box.face_field();
            for (int c = 0; c < 3; ++c)
              for_each(exchange.beta[c].box(), [&](int i, int j, int k) {
                const double beta = 3 + 2 * std::sin(1.0 * i + 2 * j + 3 * k);
                exchange.beta[c](i, j, k) = beta;
                exchange.source[c](i, j, k) = beta * s.initial_velocity[c];
              });
          }
          double previous = 0, error = 0;
          for (int step = 0; step < 20; ++step) {
            const double dt = 0.02 * (constant_dt ? 1.0 : 1 + 0.4 * std::sin(2.0 * step));
            auto next = carried(box.grid.axis[d], U, dt, previous > 0 ? dt / previous : 0, now, old);
            old = now, now = next, previous = dt;
            put(box.eps_end, now);
            box.step(dt, exchange);
            box.eps_begin = box.eps_end;
          }
          for (int c = 0; c < 3; ++c)
            for_each(box.faces(c), [&](int i, int j, int k) {
              error = std::max(error, std::abs(box.fluid->velocity()[c](i, j, k) - s.initial_velocity[c]));
            });
          error = box.largest(error) / U;
          if (d == 0)
            report("uniform flow, own flux, %s, dt %s, drag %s: deviation %.1e\n",
                   scheme == Convection::kCentral ? "central" : "van Leer", constant_dt ? "constant" : "varying",
                   drag ? "on" : "off", error);
          EXPECT_LT(error, 1e-10);
        }
}

TEST(UniformFlow, CarriesAGivenVoidFractionAtOrderTwo) {
  // eps moves exactly with the flow, as particles that follow it would deposit it.
  for (Convection scheme : {Convection::kCentral, Convection::kVanLeer}) {
    double error[3];
    for (int level = 0; level < 3; ++level) {
      const int n = 16 << level, steps = 20 << level;
      FluidSettings s = inviscid(scheme);
      s.pressure_rtol = 1e-9;
      s.initial_velocity = {1, 0.5, 0};
      CfdBox box({uniform(0, 1, n), uniform(0, 1, n), uniform(0, 1.0 / n, 1)}, {true, true, true}, s);
      auto eps = [&](double t) -> Function {
        return [t](double x, double y, double) {
          return 0.6 + 0.25 * std::sin(2 * kPi * (x - t)) * std::cos(2 * kPi * (y - 0.5 * t));
        };
      };
      const double dt = 0.5 / steps;
      auto u = box.face_field();
      for (int d = 0; d < 3; ++d) u[d].fill(s.initial_velocity[d]);
      CellField<FineGrid> p(box.eps_begin.box()), old(box.eps_begin.box());
      box.set(box.eps_begin, eps(0)), box.set(old, eps(-dt));
      box.fluid->set_state(0, u, p, box.eps_begin, dt, u, old);
      for (int step = 1; step <= steps; ++step) {
        box.set(box.eps_end, eps(step * dt));
        box.step(dt);
        box.eps_begin = box.eps_end;
      }
      error[level] = std::hypot(box.face_error(0, [](double, double, double) { return 1.0; }),
                                box.face_error(1, [](double, double, double) { return 0.5; }));
    }
    report("uniform flow, eps given, %s: error %.2e %.2e %.2e, order %.2f %.2f\n",
           scheme == Convection::kCentral ? "central" : "van Leer", error[0], error[1], error[2],
           std::log2(error[0] / error[1]), std::log2(error[1] / error[2]));
    EXPECT_GT(std::log2(error[1] / error[2]), 1.9);
    EXPECT_LT(error[2], 0.01);
  }
}

TEST(UniformFlow, CarriesDepositedParticlesWithoutGrowingNoise) {
  // Particles that move with the flow, deposited trilinearly: d(eps)/dt is as rough as the arrangement of particles.
  // Without it, momentum carried by a flux that misses the particles' noise could heat up the flow step by step.
  for (double courant : {0.4, 0.1}) {
    const int n = 24, per_cell = 6;
    const double h = 1.0 / n, dt = courant * h, U = 1, V = 0.6;
    FluidSettings s = inviscid(Convection::kVanLeer);
    s.pressure_rtol = 1e-7;
    s.initial_velocity = {U, V, 0};
    CfdBox box({uniform(0, 1, n), uniform(0, 1, n), uniform(0, h, 1)}, {true, true, true}, s);
    std::vector<double> x, y;  // in cells
    std::uint64_t seed = 12345;
    auto random = [&seed] {
      seed = seed * 6364136223846793005ull + 1442695040888963407ull;
      return double(seed >> 11) / 9007199254740992.0;
    };
    for (int q = 0; q < per_cell * n * n; ++q) x.push_back(n * random()), y.push_back(n * random());
    auto deposit = [&](CellField<FineGrid>& eps, double t) {
      std::vector<double> solid(n * n, 0.0);
      for (std::size_t q = 0; q < x.size(); ++q) {
        const double a = x[q] + U * t / h - 0.5, b = y[q] + V * t / h - 0.5;
        const int i = int(std::floor(a)), j = int(std::floor(b));
        for (int di : {0, 1})
          for (int dj : {0, 1}) {
            const double w = (di ? a - i : 1 - a + i) * (dj ? b - j : 1 - b + j);
            solid[((i + di) % n + n) % n + n * (((j + dj) % n + n) % n)] += w * 0.3 / per_cell;
          }
      }
      for_each(eps.box(),
               [&](int i, int j, int k) { eps(i, j, k) = 1 - solid[(i + n) % n + n * ((j + n) % n)] + 0 * k; });
    };
    deposit(box.eps_begin, 0);
    auto u = box.face_field();
    u[0].fill(U), u[1].fill(V);
    box.fluid->set_state(0, u, CellField<FineGrid>(box.eps_begin.box()), box.eps_begin, 0, u, box.eps_begin);
    double spread[2] = {0, 0};  // standard deviation and mean of eps
    for_each(box.own(), [&](int i, int j, int k) {
      spread[0] += (box.eps_begin(i, j, k) - 0.7) * (box.eps_begin(i, j, k) - 0.7), spread[1] += 1;
    });
    const double noise = std::sqrt(box.sum(spread[0]) / box.sum(spread[1])) / 0.7;
    double rms[4];
    int step = 0;
    for (int part = 0; part < 4; ++part) {
      for (; step * dt < 0.5 * (part + 1) - 1e-9; ++step) {
        deposit(box.eps_end, (step + 1) * dt);
        box.step(dt);
        box.eps_begin = box.eps_end;
      }
      rms[part] = std::hypot(box.face_error(0, [&](double, double, double) { return U; }),
                             box.face_error(1, [&](double, double, double) { return V; }));
    }
    report(
        "uniform flow, deposited particles, Courant number %.1f: rms of eps/mean %.4f, of u - U at t = 0.5 1 1.5 2: "
        "%.4f %.4f "
        "%.4f %.4f\n",
        courant, noise, rms[0], rms[1], rms[2], rms[3]);
    // The flux of continuity itself is as rough as eps; more than that would be made by the transport.
    EXPECT_LT(rms[3], 1.2 * noise * std::hypot(U, V));
    EXPECT_LT(rms[3], 1.1 * rms[0]);
  }
}

namespace {

/// Duct along d, inlet at the low side with speed 1, outlet with p = 0; eps(x) between (1 at both ends). Returns the
/// largest deviation of p + head from its value in front of the bed, over rho U^2, of cells whose neighbours' eps
/// differs by less than `jump` from their own.
double duct(int d, int n, bool formulation_a, Convection scheme, const std::function<double(double)>& eps,
            double jump = 1) {
  FluidSettings s = inviscid(scheme);
  s.pressure_rtol = 1e-11;
  const double dt = 0.15 / n;
  for (int side = 0; side < 6; ++side) s.side[side] = {condition(BoundaryKind::kSlip)};
  Vec3 U{0, 0, 0};
  U[d] = 1;
  s.side[2 * d] = {condition(BoundaryKind::kInlet, U)};
  s.side[2 * d + 1] = {condition(BoundaryKind::kPressure)};
  std::array<std::vector<double>, 3> nodes{uniform(0, 0.1, 1), uniform(0, 0.1, 1), uniform(0, 0.1, 1)};
  nodes[d] = uniform(0, 1, n);
  CfdBox box(nodes, {false, false, false}, s);
  box.set(box.eps_begin, [&](double x, double y, double z) {
    const double q[3] = {x, y, z};
    return eps(q[d]);
  });
  box.eps_end = box.eps_begin;
  box.fluid->start(box.eps_begin);
  // Continuity alone gives u in one dimension; p is steady when the first step's start has died away.
  FormulationA particles(box);
  for (int k = 0; k < (formulation_a ? 80 : 40); ++k) {
    box.step(dt, formulation_a ? particles.exchange({}, {}, {}) : kNoParticles);
    if (formulation_a) particles.read();
  }
  // u at a cell's centre is U/eps there.
  double most = 0;
  for_each(box.own(), [&](int i, int j, int k) {
    const double e = box.eps_begin(i, j, k);
    Int3 lo{i, j, k}, hi{i, j, k};
    --lo[d], ++hi[d];
    const double below = box.eps_begin(lo[0], lo[1], lo[2]), above = box.eps_begin(hi[0], hi[1], hi[2]);
    if (std::max(std::abs(e - below), std::abs(e - above)) > jump) return;
    const double head = box.fluid->density() * (formulation_a ? 0.5 / (e * e) : 1 / e);
    const double front = box.fluid->density() * (formulation_a ? 0.5 : 1.0);
    most = std::max(most, std::abs(box.fluid->pressure()(i, j, k) + head - front));
  });
  return box.largest(most) / box.fluid->density();
}

}  // namespace

TEST(VoidFractionJump, HeadIsConstantInAStillBed) {
  // Without it, A and B could be mixed up, or a jump of eps could act as a source of pressure.
  for (bool a : {true, false})
    for (Convection scheme : {Convection::kCentral, Convection::kVanLeer}) {
      double error[3];
      for (int level = 0; level < 3; ++level)
        error[level] = duct(level, 32 << level, a, scheme, [](double x) {
          const double width = 0.05;
          return 1 - 0.3 * (std::tanh((x - 0.35) / width) - std::tanh((x - 0.7) / width));
        });
      // The bare jump across one face: all cells but the two next to it, whose u is the mean of two faces.
      double jump[2];
      for (int level = 0; level < 2; ++level)
        jump[level] = duct(
            0, 20 << level, a, scheme, [](double x) { return x > 0.4 && x < 0.7 ? 0.4 : 1.0; }, 0.1);
      report("jump of eps 1-0.4-1, %s, %s: smooth %.2e %.2e %.2e order %.2f; bare %.2e %.2e\n", a ? "A" : "B",
             scheme == Convection::kCentral ? "central" : "van Leer", error[0], error[1], error[2],
             std::log2(error[1] / error[2]), jump[0], jump[1]);
      EXPECT_GT(std::log2(error[1] / error[2]), 1.9);
      // A limiter that took the jump of u = U/eps for a front would lose 0.87 rho U^2 in A, on any grid.
      EXPECT_LT(std::max(jump[0], jump[1]), 1e-8);
    }
}

TEST(VoidFractionJump, HeadIsConstantInAMovingBed) {
  // In the bed's frame the flow is steady: u = c + Q/eps. Without it, d(eps)/dt in the inertia could be wrong.
  for (bool a : {true, false})
    for (int d : {0, 1, 2}) {
      double eu[3], ep[3];
      for (int level = 0; level < 3; ++level) {
        const int n = 32 << level, steps = a ? 40 << (2 * level) : 40 << level;
        const double c = 0.6, Q = 0.4, dt = 0.25 / steps;
        FluidSettings s = inviscid(Convection::kCentral);
        s.pressure_rtol = 1e-11;
        std::array<std::vector<double>, 3> nodes{uniform(0, 0.1, 1), uniform(0, 0.1, 1), uniform(0, 0.1, 1)};
        nodes[d] = uniform(0, 1, n);
        CfdBox box(nodes, {true, true, true}, s);
        auto along = [d](std::function<double(double)> f) -> Function {
          return [d, f](double x, double y, double z) { return f(d == 0 ? x : d == 1 ? y : z); };
        };
        auto eps = [&](double t) { return [=](double x) { return 0.7 + 0.3 * std::sin(2 * kPi * (x - c * t)); }; };
        auto speed = [&](double t) { return [=](double x) { return c + Q / eps(t)(x); }; };
        auto pressure = [&](double t) {
          return [=](double x) {
            const double e = eps(t)(x);
            return -1.2 * Q * Q * (a ? 0.5 / (e * e) : 1 / e);
          };
        };
        auto u = box.face_field(), u_old = box.face_field();
        box.set_faces(d, u[d], along(speed(0))), box.set_faces(d, u_old[d], along(speed(-dt)));
        CellField<FineGrid> p(box.eps_begin.box()), old(box.eps_begin.box());
        box.set(p, along(pressure(0)));
        box.set(box.eps_begin, along(eps(0))), box.set(old, along(eps(-dt)));
        box.fluid->set_state(0, u, p, box.eps_begin, dt, u_old, old);
        FormulationA particles(box);
        for (int k = 0; k < 40 && a; ++k) {  // the pressure force of the beginning
          box.set(box.eps_end, along(eps(dt)));
          box.step(dt, particles.exchange({}, {}, {}));
          particles.read();
          box.fluid->set_state(0, u, p, box.eps_begin, dt, u_old, old);
        }
        for (int step = 1; step <= steps; ++step) {
          box.set(box.eps_end, along(eps(step * dt)));
          box.step(dt, a ? particles.exchange({}, {}, {}) : kNoParticles);
          if (a) particles.read();
          box.eps_begin = box.eps_end;
        }
        eu[level] = box.face_error(d, along(speed(0.25)));
        ep[level] = box.pressure_error(along(pressure(0.25)), true);
      }
      if (d == 0)
        report("moving bed, %s: u %.2e %.2e %.2e order %.2f, p %.2e %.2e %.2e order %.2f\n", a ? "A" : "B", eu[0],
               eu[1], eu[2], std::log2(eu[1] / eu[2]), ep[0], ep[1], ep[2], std::log2(ep[1] / ep[2]));
      EXPECT_GT(std::log2(eu[1] / eu[2]), 1.9);
      EXPECT_GT(std::log2(ep[1] / ep[2]), 1.8);
    }
}

TEST(VoidFractionJump, BareJumpThatMovesStaysBoundedAndConverges) {
  // A slab of eps = 0.4 with bare fronts moves through the fluid: u = c + Q/eps. Without it, an overshoot of u at a
  // front that crosses cells, or an error of p that doesn't fall with h, would pass; smooth profiles don't show it.
  for (bool a : {true, false})
    for (Convection scheme : {Convection::kCentral, Convection::kVanLeer}) {
      double over[3], ep[3];
      for (int level = 0; level < 3; ++level) {
        const int n = 32 << level, steps = 640 << level;
        const double c = 0.6, Q = 0.4, dt = 0.25 / steps;
        FluidSettings s = inviscid(scheme);
        s.pressure_rtol = 1e-11;
        s.initial_velocity = {c + Q, 0, 0};
        for (int side = 0; side < 6; ++side) s.side[side] = {condition(BoundaryKind::kSlip)};
        s.side[0] = {condition(BoundaryKind::kInlet, {c + Q, 0, 0})};
        s.side[1] = {condition(BoundaryKind::kPressure)};
        CfdBox box({uniform(0, 1, n), uniform(0, 0.1, 1), uniform(0, 0.1, 1)}, {false, false, false}, s);
        auto solid = [](double x, double from) { return std::min(std::max(x - from, 0.0), 0.3); };
        auto eps = [&](double t) {  // mean over a cell
          const double from = 0.2 + c * t;
          return [=](double x, double, double) {
            return 1 - 0.6 * n * (solid(x + 0.5 / n, from) - solid(x - 0.5 / n, from));
          };
        };
        box.set(box.eps_begin, eps(0));
        box.fluid->start(box.eps_begin);
        FormulationA particles(box);
        over[level] = 0;
        double mean[2] = {0, 0};  // of p in the slab, of p in front of it; less than 0.05 off its fronts is left out
        int samples = 0;
        for (int step = 1; step <= steps; ++step) {
          box.set(box.eps_end, eps(step * dt));
          box.step(dt, a ? particles.exchange({}, {}, {}) : kNoParticles);
          if (a) particles.read();
          box.eps_begin = box.eps_end;
          if (step <= steps / 4) continue;  // the slab is set in motion at once
          ++samples;
          const double from = 0.2 + c * step * dt;
          double sum[4] = {0, 0, 0, 0};
          for_each(box.own(), [&](int i, int j, int k) {
            const double x = box.cell(i, j, k)[0], p = box.fluid->pressure()(i, j, k);
            if (x > from + 0.05 && x < from + 0.25) sum[0] += p, sum[1] += 1;
            if (x < from - 0.05) sum[2] += p, sum[3] += 1;
          });
          for (double& q : sum) q = box.sum(q);
          mean[0] += sum[0] / sum[1], mean[1] += sum[2] / sum[3];
          double most = 0;
          for_each(box.faces(0), [&](int i, int j, int k) {
            const double u = box.fluid->velocity()[0](i, j, k);
            most = std::max({most, u - (c + Q / 0.4), c + Q - u});
          });
          over[level] = std::max(over[level], box.largest(most));
        }
        const double e = 0.4, drop = 1.2 * Q * Q * (a ? 0.5 / (e * e) - 0.5 : 1 / e - 1);
        ep[level] = std::abs((mean[1] - mean[0]) / samples / drop - 1);
      }
      report(
          "moving bare jump 1-0.4-1, %s, %s: overshoot of u %.2f %.2f %.2f, error of the mean drop of p %.4f %.4f "
          "%.4f\n",
          a ? "A" : "B", scheme == Convection::kCentral ? "central" : "van Leer", over[0], over[1], over[2], ep[0],
          ep[1], ep[2]);
      EXPECT_LT(std::max({over[0], over[1], over[2]}), 0.5 * 0.6 * 0.6 / 0.4);
      EXPECT_LT(ep[2], 0.5 * ep[0]);
      EXPECT_LT(ep[2], 0.04);
    }
}
