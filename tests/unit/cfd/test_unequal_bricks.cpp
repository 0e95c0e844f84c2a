// The fluid on bricks of every size, as borders that follow the particles make them: very unequal, one cell thick, and
// without any cell, in one direction or in several. The flow is that of one rank. Without this test a fluid that begins
// after the balance has moved the borders (fix twogrid defined anew, a bed in a corner of the box) could find a rank
// that has no cells in one direction but a length in the others, and end there.
#include <gtest/gtest.h>

#include <random>
#include <sstream>
#include <string>

#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

enum class Flow { kOpen, kChannel, kFlat };

struct Fields {
  std::array<std::vector<double>, 3> u;
  std::vector<double> p;
};

/// Five intervals with drag in a void fraction that varies.
Fields flow(Flow kind, MPI_Comm comm, const CfdBox::Cuts* cuts) {
  const Int3 n{8, kind == Flow::kFlat ? 1 : 6, 10};
  FluidSettings s;
  s.density = 1.2, s.viscosity = 1e-3, s.pressure_rtol = 1e-13;
  std::array<bool, 3> periodic{kind != Flow::kFlat, false, kind == Flow::kChannel};
  for (int side = 0; side < 6; ++side)
    if (!periodic[direction(side)])
      s.side[side] = {condition(side / 2 == 1 && kind == Flow::kChannel ? BoundaryKind::kNoSlip : BoundaryKind::kSlip)};
  if (kind == Flow::kChannel) {
    s.implicit_viscosity = Choice::kOn, s.convection = Convection::kCentral;
    s.flow_rate_set[2] = true, s.flow_rate[2] = 0.5;
  } else {
    s.side[kZlo] = {condition(BoundaryKind::kInlet, {0, 0, 0.7})};
    s.side[kZhi] = {condition(BoundaryKind::kPressure)};
  }
  CfdBox box({uniform(0, 0.01, n[0]), uniform(0, 0.008, n[1]), uniform(0, 0.02, n[2])}, periodic, s, comm, cuts);
  const auto eps = [](double t) -> Function {
    return [t](double x, double y, double z) {
      return 0.6 + 0.2 * std::sin(628.3185307179586 * (x + t)) * std::cos(500 * y) * std::sin(314.1592653589793 * z);
    };
  };
  box.set(box.eps_begin, eps(0));
  box.fluid->start(box.eps_begin);
  FieldExchange exchange;
  exchange.beta = box.face_field();
  const double interval = 2e-4;
  for (int k = 1; k <= 5; ++k) {
    box.set(box.eps_end, eps(0.2 * k * interval));
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d),
               [&](int i, int j, int l) { exchange.beta[d](i, j, l) = 200.0 * (1 + i % 3 + j % 2 + l % 4); });
    box.step(interval, exchange);
    box.eps_begin = box.eps_end;
  }
  Fields out;
  for (int d = 0; d < 3; ++d) out.u[d] = box.gathered(d, box.fluid->velocity()[d]);
  out.p = box.gathered(box.fluid->pressure());
  return out;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0, scale = 0;
  for (std::size_t m = 0; m < a.size(); ++m)
    most = std::max(most, std::isfinite(b[m]) ? std::abs(a[m] - b[m]) : 1e300), scale = std::max(scale, std::abs(a[m]));
  return scale > 0 ? most / scale : most;
}

/// All ways to share the ranks out to the directions, each with cuts of several kinds.
std::vector<CfdBox::Cuts> all_cuts(const Int3& n, int ranks) {
  std::vector<CfdBox::Cuts> all;
  std::mt19937 random(5);
  for (int pz = 1; pz <= ranks; ++pz)
    for (int py = 1; ranks % pz == 0 && py <= ranks / pz; ++py) {
      if ((ranks / pz) % py) continue;
      const Int3 p{ranks / pz / py, py, pz};
      for (int kind = 0; kind < 4; ++kind) {
        CfdBox::Cuts cuts;
        for (int d = 0; d < 3; ++d) {
          cuts[d].assign(p[d] + 1, 0);
          for (int a = 1; a < p[d]; ++a)
            cuts[d][a] = kind == 0   ? 0                  // all in the last brick
                         : kind == 1 ? n[d]               // all in the first
                         : kind == 2 ? std::min(a, n[d])  // one cell each, the rest in the last
                                     : int(random() % unsigned(n[d] + 1));
          cuts[d][p[d]] = n[d];
          std::sort(cuts[d].begin(), cuts[d].end());
        }
        all.push_back(cuts);
      }
    }
  return all;
}

}  // namespace

TEST(UnequalBricks, TheFlowIsThatOfOneRank) {
  for (Flow kind : {Flow::kOpen, Flow::kChannel, Flow::kFlat}) {
    const Fields one = flow(kind, MPI_COMM_SELF, nullptr);
    double worst = 0;
    for (const CfdBox::Cuts& cuts : all_cuts({8, kind == Flow::kFlat ? 1 : 6, 10}, ranks_of(MPI_COMM_WORLD))) {
      const Fields here = flow(kind, MPI_COMM_WORLD, &cuts);
      double most = difference(one.p, here.p);
      for (int d = 0; d < 3; ++d)
        if (difference(one.u[d], std::vector<double>(one.u[d].size(), 0.0)) > 0)
          most = std::max(most, difference(one.u[d], here.u[d]));
      std::ostringstream where;
      for (const auto& c : cuts)
        for (int x : c) where << x << (x == c.back() && &x == &c.back() ? "; " : " ");
      EXPECT_LT(most, 1e-9) << "flow " << int(kind) << ", cuts " << where.str();
      worst = std::max(worst, most);
    }
    report("bricks of every size, flow %d: within %.1e of one rank's\n", int(kind), worst);
  }
}
