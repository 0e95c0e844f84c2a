// The same flow when axes or ranks are exchanged.
#include <gtest/gtest.h>

#include <string>

#include "cfd/parallel/ranks.h"
#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"
#include "tests/verification/formulation_a.h"

using namespace twogrid;

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
  FieldExchange exchange;
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
  const int ranks = ranks_of(MPI_COMM_WORLD);
  report("jet on 1 and on %d ranks: differs by %.1e\n", ranks, e);
  EXPECT_LT(e, 1e-9);
}

TEST(Ranks, SameFlowBesideRanksOneCellThick) {
  // A halo of two reaches over such a rank to the ghosts beyond a side, which no rank owns. Without the test they may
  // stay as they were, and only flow towards the inside of the domain, near a wall, would show it.
  const int ranks = ranks_of(MPI_COMM_WORLD);
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
