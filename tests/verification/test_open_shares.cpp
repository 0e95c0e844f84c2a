// Open shares of faces and cells (cfd/measures/open_shares.h). Without these, a solver that drops area, divides by a
// closed face's zero, lets gas creep that is at rest, or feels a wall that is not there or not one that is, would pass.
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

/// A number in [0,1) that hangs on the index alone, and so not on the ranks.
double number(int i, int j, int k, int salt) {
  std::uint64_t x = std::uint64_t(i + 7) * 0x9E3779B97F4A7C15ull ^ std::uint64_t(j + 11) * 0xC2B2AE3D27D4EB4Full ^
                    std::uint64_t(k + 13) * 0x165667B19E3779F9ull ^ std::uint64_t(salt + 1) * 0x27D4EB2F165667C5ull;
  x ^= x >> 31, x *= 0xBF58476D1CE4E5B9ull, x ^= x >> 29, x *= 0x94D049BB133111EBull, x ^= x >> 32;
  return double(x >> 11) * 0x1p-53;
}

/// Closes the cells that `solid` names, and their faces.
OpenSpaceModel closing(std::function<bool(const Int3&)> solid) {
  return [solid](const FineGrid& grid, OpenSpace& space) {
    const auto in = [&](Int3 x) {
      for (int d = 0; d < 3; ++d) {
        const int n = grid.axis[d].n();
        if (grid.axis[d].periodic())
          x[d] = (x[d] + n) % n;
        else
          x[d] = std::min(std::max(x[d], 0), n - 1);
      }
      return solid(x);
    };
    for_each(space.theta.box(), [&](int i, int j, int k) {
      if (in({i, j, k})) space.theta(i, j, k) = 0;
    });
    for (int d = 0; d < 3; ++d)
      for_each(space.alpha[d].box(), [&](int i, int j, int k) {
        Int3 below{i, j, k};
        --below[d];
        if (in({i, j, k}) || in(below)) space.alpha[d](i, j, k) = 0;
      });
  };
}

/// Random shares: alpha in (0.05, 1], every 11th face closed; theta of a cell: the mean of its faces'.
void random_shares(const FineGrid& grid, OpenSpace& space) {
  const auto alpha = [&](int d, Int3 x) {
    const Axis& a = grid.axis[d];
    if (a.periodic()) x[d] = (x[d] + a.n()) % a.n();
    const double r = number(x[0], x[1], x[2], d);
    return r < 1.0 / 11 ? 0.0 : 0.05 + 0.95 * r;
  };
  for (int d = 0; d < 3; ++d)
    for_each(space.alpha[d].box(), [&](int i, int j, int k) { space.alpha[d](i, j, k) = alpha(d, {i, j, k}); });
  for_each(space.theta.box(), [&](int i, int j, int k) {
    double sum = 0;
    for (int d = 0; d < 3; ++d) {
      Int3 next{i, j, k};
      ++next[d];
      sum += alpha(d, {i, j, k}) + alpha(d, next);
    }
    space.theta(i, j, k) = sum / 6;
  });
}

FluidSettings gas() {
  FluidSettings s;
  s.density = 1.2;
  s.viscosity = 1e-2;
  s.pressure_rtol = 1e-11;
  return s;
}

std::vector<double> graded(double length, int n) {
  return graded_nodes(0, length, n, 1.1);
}

/// Largest difference of two boxes' velocities and pressures' gradients, over the largest speed and gradient.
double difference(const CfdBox& a, const CfdBox& b) {
  double worst = 0;
  for (int d = 0; d < 3; ++d) {
    const auto ua = a.gathered(d, a.fluid->velocity()[d]), ub = b.gathered(d, b.fluid->velocity()[d]);
    for (std::size_t m = 0; m < ua.size(); ++m) worst = std::max(worst, std::abs(ua[m] - ub[m]));
  }
  return worst;
}

/// Largest |d(theta eps)/dt + sum of fluxes/V| h, by what the solver says of its last step.
double continuity(const CfdBox& box) {
  double worst = 0;
  for_each(box.own(), [&](int i, int j, int k) {
    double sum = box.fluid->void_fraction_rate(i, j, k) * box.grid.volume(i, j, k);
    for (int d = 0; d < 3; ++d) {
      Int3 next{i, j, k};
      ++next[d];
      sum += box.grid.area(d, i, j, k) * (box.fluid->flux(d, next[0], next[1], next[2]) - box.fluid->flux(d, i, j, k));
    }
    const double V = box.grid.volume(i, j, k);
    worst = std::max(worst, std::abs(sum) / std::pow(V, 2.0 / 3));
  });
  return box.largest(worst);
}

/// A jet from below into a box of 8 x 6 x 10 cells with an outlet above, along z turned to `along`.
FluidSettings jet(int along) {
  FluidSettings s = gas();
  for (auto& side : s.side) side = {condition(BoundaryKind::kNoSlip)};
  Vec3 up{0, 0, 0};
  up[along] = 1;
  s.side[2 * along] = {condition(BoundaryKind::kInlet, up)};
  s.side[2 * along + 1] = {condition(BoundaryKind::kPressure)};
  return s;
}

std::array<std::vector<double>, 3> nodes_along(int along, int n0, int n1, int n2) {
  std::array<std::vector<double>, 3> nodes;
  nodes[(along + 1) % 3] = graded(0.08, n0), nodes[(along + 2) % 3] = graded(0.06, n1), nodes[along] = graded(0.1, n2);
  return nodes;
}

}  // namespace

TEST(OpenShares, AllOpenIsNone) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
    for (Choice implicit : {Choice::kOff, Choice::kOn}) {
      FluidSettings s = jet(2);
      s.convection = scheme;
      s.implicit_viscosity = implicit;
      CfdBox none(nodes_along(2, 8, 6, 10), {false, false, false}, s);
      s.open_space = [](const FineGrid&, OpenSpace&) {};
      CfdBox open(nodes_along(2, 8, 6, 10), {false, false, false}, s);
      ASSERT_NE(open.fluid->open_shares(), nullptr);
      for (CfdBox* box : {&none, &open}) {
        box->set(box->eps_begin, [](double x, double, double z) { return 0.6 + 4 * z * x / 0.08; });
        box->fluid->start(box->eps_begin);
        box->set(box->eps_end, [](double x, double, double z) { return 0.6 + 4.2 * z * x / 0.08; });
        for (int step = 0; step < 3; ++step) {
          box->step(0.01);
          box->eps_begin = box->eps_end;
        }
      }
      const double apart = difference(none, open);
      report("all open: difference of velocity %.1e m/s\n", apart);
      EXPECT_LT(apart, 1e-13);
    }
}

/// A box half of whose width is solid, against one of the half width: the same at every step where no friction of the
/// walls comes in and where no limiter looks beyond them.
TEST(OpenShares, ClosedHalfIsANarrowerBox) {
  for (int along : {0, 1, 2})
    for (bool high : {false, true}) {
      FluidSettings s = jet(along);
      s.convection = Convection::kCentral;
      const int across = (along + 1) % 3, other = (along + 2) % 3;
      for (int side = 0; side < 6; ++side)
        if (direction(side) != along) s.side[side] = {condition(BoundaryKind::kSlip)};
      // A slot jet, so that the gas spreads sideways.
      BoundaryCondition still = condition(BoundaryKind::kNoSlip);
      still.shape.kind = PatchShape::Kind::kRectangle;
      const bool first = across < other;
      const std::array<double, 2> over{0, 0.06},
          part = high ? std::array<double, 2>{0.06, 0.08} : std::array<double, 2>{0, 0.02};
      still.shape.value = first ? std::array<double, 4>{part[0], part[1], over[0], over[1]}
                                : std::array<double, 4>{over[0], over[1], part[0], part[1]};
      s.side[2 * along].push_back(still);
      std::array<std::vector<double>, 3> wide = nodes_along(along, 8, 6, 10), narrow = wide;
      wide[across] = uniform(0, 0.08, 8);
      narrow[across] = high ? uniform(0.04, 0.08, 4) : uniform(0, 0.04, 4);
      CfdBox alone(narrow, {false, false, false}, s);
      s.open_space = closing([=](const Int3& x) { return high ? x[across] < 4 : x[across] >= 4; });
      CfdBox half(wide, {false, false, false}, s);
      for (int step = 0; step < 8; ++step) alone.step(0.004), half.step(0.004);
      double worst = 0, fastest = 0, sideways = 0;
      for (int d = 0; d < 3; ++d) {
        const auto u = alone.gathered(d, alone.fluid->velocity()[d]), v = half.gathered(d, half.fluid->velocity()[d]);
        Box faces{{0, 0, 0}, alone.grid.n()};
        for_each(faces, [&](int i, int j, int k) {
          Int3 x{i, j, k};
          if (high) x[across] += 4;
          const double a = u[alone.at(i, j, k)], b = v[half.at(x[0], x[1], x[2])];
          worst = std::max(worst, std::abs(a - b)), fastest = std::max(fastest, std::abs(a));
          if (d == across) sideways = std::max(sideways, std::abs(a));
        });
      }
      report("half closed along %d: difference %.1e of %.2f m/s, sideways %.2f\n", along, worst, fastest, sideways);
      EXPECT_GT(sideways, 0.1);
      EXPECT_LT(worst, 2e-9 * fastest);
      EXPECT_LT(continuity(half), 1e-9);
    }
}

TEST(OpenShares, ContinuityOfEveryCell) {
  for (int along : {0, 1, 2}) {
    FluidSettings s = jet(along);
    s.open_space = random_shares;
    CfdBox box(nodes_along(along, 8, 6, 10), {false, false, false}, s);
    box.set(box.eps_begin, [](double x, double y, double) { return 0.5 + 3 * x + y; });
    box.fluid->start(box.eps_begin);
    FluidReport r;
    double worst = 0;
    for (int step = 0; step < 5; ++step) {
      box.set(box.eps_end,
              [&](double x, double y, double z) { return 0.5 + 3 * x + y + 0.004 * (step + 1) * z / 0.1; });
      r = box.step(1e-3);
      box.eps_begin = box.eps_end;
      worst = std::max(worst, continuity(box));
    }
    double inlet = 0;
    for (const PatchArea& a : box.fluid->boundaries().areas(box.comm())) inlet += a.flux;
    report("random shares along %d: continuity %.1e m/s, in %.6e, out %.6e, displaced %.3e\n", along, worst, r.inflow,
           r.outflow, r.displaced);
    EXPECT_LT(worst, 1e-8);
    EXPECT_LT(r.divergence_error, 1e-8);
    EXPECT_NEAR(r.inflow, inlet, 1e-12 * inlet);
    EXPECT_NEAR(r.outflow, r.inflow + r.displaced, 1e-10 * r.inflow);
    EXPECT_LT(inlet, 0.8 * 0.08 * 0.06);
  }
}

/// A closed box with G = f, against which a body force of the same size pushes; and hydrostatic pressure.
TEST(OpenShares, GasAtRestStaysAtRest) {
  for (int d : {0, 1, 2})
    for (bool hydrostatic : {false, true}) {
      FluidSettings s = gas();
      for (auto& side : s.side) side = {condition(BoundaryKind::kNoSlip)};
      if (!hydrostatic) s.side[5] = {condition(BoundaryKind::kPressure, {0, 0, 0}, 3)};
      s.open_space = random_shares;
      CfdBox box(nodes_along(2, 7, 6, 9), {false, false, false}, s);
      const double f = hydrostatic ? 12 : 0;
      auto zero = box.face_field();
      CellField<FineGrid> p(box.eps_begin.box());
      box.set(p, [&](double x, double y, double z) {
        return hydrostatic ? f * std::array<double, 3>{x, y, z}[d] : 3.0;
      });
      box.set(box.eps_begin, [](double x, double y, double) { return 0.5 + 3 * x + y; });
      box.eps_end = box.eps_begin;
      box.fluid->set_state(0, zero, p, box.eps_begin, 0, zero, box.eps_begin);
      Interphase exchange;
      if (hydrostatic) {
        for (int c = 0; c < 3; ++c) exchange.source[c].reset(box.faces(c));
        for_each(box.faces(d), [&](int i, int j, int k) {
          exchange.source[d](i, j, k) = f * box.fluid->open_shares()->theta_f()[d](i, j, k);
        });
      }
      for (int step = 0; step < 10; ++step) box.step(1e-3, exchange);
      double fastest = 0;
      for (int c = 0; c < 3; ++c)
        for_each(box.faces(c), [&](int i, int j, int k) {
          fastest = std::max(fastest, std::abs(box.fluid->velocity()[c](i, j, k)));
        });
      fastest = box.largest(fastest);
      report("at rest, %d: %.1e m/s\n", d, fastest);
      EXPECT_LT(fastest, 1e-12);
    }
}

/// A closed, periodic box with a given flow through bodies: the mean flux over the open volume is held, every cell
/// keeps its continuity while the solids in it grow.
TEST(OpenShares, FlowRateThroughClosedCells) {
  FluidSettings s = gas();
  for (int side : {0, 1, 4, 5}) s.side[side] = {condition(BoundaryKind::kSlip)};
  s.flow_rate_set[1] = true;
  s.flow_rate[1] = 0.3;
  s.open_space = closing([](const Int3& x) {
    const double a = x[0] - 5.5, b = x[1] - 9.5;
    return a * a + b * b < 10 || x[2] > 5;
  });
  CfdBox box({uniform(0, 0.12, 12), uniform(0, 0.2, 20), uniform(0, 0.08, 8)}, {false, true, false}, s);
  for (int step = 0; step < 6; ++step) {
    box.set(box.eps_end,
            [&](double, double y, double) { return 1 - 0.01 * (step + 1) * std::sin(31.41592653589793 * y); });
    box.step(2e-3);
    box.eps_begin = box.eps_end;
  }
  double flux[2] = {0, 0};
  for_each(box.own(), [&](int i, int j, int k) {
    flux[0] += box.fluid->flux(1, i, j, k) * box.grid.area(1, i, j, k) * box.grid.axis[1].face_width(j);
    flux[1] += box.fluid->open_shares()->theta()(i, j, k) * box.grid.volume(i, j, k);
  });
  const double mean = box.sum(flux[0]) / box.sum(flux[1]), worst = continuity(box);
  report("flow rate through closed cells: %.12f m/s, continuity %.1e m/s\n", mean, worst);
  EXPECT_NEAR(mean, 0.3, 1e-10);
  EXPECT_LT(worst, 1e-9);
}

/// Between solid cells, with K' = 2/h^2 for each wall half a cell away, the steady flow is that of a box of that width
/// between no-slip sides, cell by cell; for a gap of one cell too.
TEST(OpenShares, PoiseuilleBetweenClosedCells) {
  for (int along : {0, 1, 2})
    for (Choice implicit : {Choice::kOn, Choice::kOff})
      for (int gap : {6, 1}) {
        const int across = (along + 1) % 3, thin = (along + 2) % 3, below = 2;
        FluidSettings s;
        s.density = 1;
        s.viscosity = 0.1;
        s.pressure_gradient[along] = -2;
        s.pressure_rtol = 1e-11;
        s.implicit_viscosity = implicit;
        s.dt = implicit == Choice::kOn ? 0.5 : 0.005;
        s.side[2 * thin] = s.side[2 * thin + 1] = {condition(BoundaryKind::kSlip)};
        const auto sides = [&](BoundaryKind kind) { s.side[2 * across] = s.side[2 * across + 1] = {condition(kind)}; };
        std::array<bool, 3> periodic{false, false, false};
        periodic[along] = true;
        const std::vector<double> all = uniform(-0.2, 0.8, 10);
        std::array<std::vector<double>, 3> nodes;
        nodes[along] = uniform(0, 0.3, 3), nodes[across] = all, nodes[thin] = uniform(0, 0.2, 2);
        sides(BoundaryKind::kSlip);
        s.open_space = [=](const FineGrid& grid, OpenSpace& space) {
          closing([=](const Int3& x) { return x[across] < below || x[across] >= below + gap; })(grid, space);
          for (int d = 0; d < 3; ++d) space.friction[d].reset(space.alpha[d].box());
          for (int d : {along, thin})
            for_each(space.alpha[d].box(), [&](int i, int j, int k) {
              const Int3 x{i, j, k};
              const double h = grid.axis[across].width(x[across]);
              space.friction[d](i, j, k) = ((x[across] == below) + (x[across] == below + gap - 1)) * 2 / (h * h);
            });
        };
        CfdBox closed(nodes, periodic, s);
        s.open_space = nullptr;
        sides(BoundaryKind::kNoSlip);
        nodes[across] = {all.begin() + below, all.begin() + below + gap + 1};
        std::unique_ptr<CfdBox> box;
        if (gap > 1) box = std::make_unique<CfdBox>(nodes, periodic, s);
        for (int step = 0; step < (implicit == Choice::kOn ? 200 : 1500); ++step) {
          closed.step(s.dt);
          if (box) box->step(s.dt);
        }
        // Discrete solution: u = G/(2 mu) (y (H - y) + h^2/4) with the wall's gradient over half a cell.
        const double H = 0.1 * gap;
        double worst = 0, apart = 0;
        for_each(closed.faces(along), [&](int i, int j, int k) {
          const Int3 x{i, j, k};
          const double y = (x[across] - below + 0.5) * 0.1, u = closed.fluid->velocity()[along](i, j, k);
          const bool in = y > 0 && y < H;
          worst = std::max(worst, std::abs(u - (in ? 10 * (y * (H - y) + 0.0025) : 0.0)));
        });
        if (box) {
          const auto u = box->gathered(along, box->fluid->velocity()[along]),
                     v = closed.gathered(along, closed.fluid->velocity()[along]);
          for_each(Box{{0, 0, 0}, box->grid.n()}, [&](int i, int j, int k) {
            Int3 x{i, j, k};
            x[across] += below;
            apart = std::max(apart, std::abs(u[box->at(i, j, k)] - v[closed.at(x[0], x[1], x[2])]));
          });
        }
        worst = closed.largest(worst);
        report("Poiseuille between closed cells along %d, gap %d: error %.1e, against the box %.1e m/s\n", along, gap,
               worst, apart);
        EXPECT_LT(worst, 1e-8);
        EXPECT_LT(apart, 1e-8);
      }
}

/// Uniform K': Darcy's law -dp/dx = mu K eps u with an inlet and an outlet, -G = mu K eps u in a periodic box.
TEST(OpenShares, UniformFrictionIsDarcysLaw) {
  const double K = 3e4;
  for (int along : {0, 1, 2})
    for (int q = 0; q < 4; ++q) {
      const bool through = q % 2 == 0;
      const double eps = q < 2 ? 1 : 0.5;
      FluidSettings s = gas();
      for (auto& side : s.side) side = {condition(BoundaryKind::kSlip)};
      std::array<bool, 3> periodic{false, false, false};
      const double U = 0.2, gradient = s.viscosity * K * U;
      if (through) {
        Vec3 in{0, 0, 0};
        in[along] = U;
        s.side[2 * along] = {condition(BoundaryKind::kInlet, in)};
        s.side[2 * along + 1] = {condition(BoundaryKind::kPressure)};
      } else {
        periodic[along] = true;
        s.side[2 * along].clear(), s.side[2 * along + 1].clear();
        s.pressure_gradient[along] = -gradient;
      }
      s.open_space = [=](const FineGrid&, OpenSpace& space) {
        for (int d = 0; d < 3; ++d) space.friction[d].reset(space.alpha[d].box(), K);
      };
      CfdBox box(nodes_along(along, 4, 3, 12), periodic, s);
      box.eps_begin.fill(eps), box.eps_end.fill(eps);
      box.fluid->start(box.eps_begin);
      for (int step = 0; step < 60; ++step) box.step(0.02);
      double worst = 0, slope = 0;
      for_each(box.faces(along), [&](int i, int j, int k) {
        // Behind the inlet, whose own plane holds no solids, the flow is still taken up to u = U/eps.
        if (through && eps < 1 && Int3{i, j, k}[along] < 2) return;
        worst = std::max(worst, std::abs(box.fluid->velocity()[along](i, j, k) * eps - U) / U);
        Int3 below{i, j, k};
        if (!through || below[along] == 0) return;
        const double h = box.grid.axis[along].face_width(below[along]);
        const int n = box.grid.n()[along];
        if (below[along] == n) return;
        --below[along];
        const double dp = box.fluid->pressure()(i, j, k) - box.fluid->pressure()(below[0], below[1], below[2]);
        slope = std::max(slope, std::abs(dp / h + gradient) / gradient);
      });
      worst = box.largest(worst), slope = box.largest(slope);
      report("Darcy along %d, eps %.1f: velocity %.1e, gradient %.1e\n", along, eps, worst, slope);
      EXPECT_LT(worst, 1e-9);
      EXPECT_LT(slope, 1e-8);
    }
}

TEST(OpenShares, ImpossibleSharesAreRefused) {
  FluidSettings s = jet(2);
  const std::array<std::vector<double>, 3> nodes{uniform(0, 1, 8), uniform(0, 1, 8), uniform(0, 1, 8)};
  const auto refused = [&](OpenSpaceModel model, const char* part) {
    s.open_space = std::move(model);
    try {
      CfdBox box(nodes, {false, false, false}, s);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what()).find(part) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused([](const FineGrid&, OpenSpace& space) { space.theta.fill(1.5); }, "between 0 and 1"));
  EXPECT_TRUE(refused(
      [](const FineGrid&, OpenSpace& space) {
        if (space.theta.box().contains(3, 3, 3)) space.theta(3, 3, 3) = 0;
      },
      "beside a closed cell"));
  EXPECT_TRUE(refused(
      [](const FineGrid&, OpenSpace& space) {
        for (auto& a : space.alpha) a.fill(0);
      },
      "none of their faces"));
  EXPECT_TRUE(refused(
      [](const FineGrid&, OpenSpace& space) {
        for (auto& a : space.alpha) a.fill(0);
        space.theta.fill(0);
      },
      "no room"));
}
