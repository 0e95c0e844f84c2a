// Flows that bodies in the grid bound, whose solutions are known (cfd/bodies, cfd/momentum/cut_links.h). Without these, a
// wall that is a cell too near, an area that counts twice, stress through a wall, friction that hangs on where the wall
// lies on the grid, or an axis taken for another would pass.
#include <gtest/gtest.h>

#include "cfd/grid/pi.h"
#include "tests/verification/bodies.h"

using namespace twogrid;

namespace {

/// Error of the flow through pipes of radius R (m) along an axis, with a rod of radius r inside or none; N cells a metre.
double pipe_error(int along, int N, double R, double r, int salt) {
  const int e = (along + 1) % 3, f = (along + 2) % 3;
  FluidSettings s = creeping(10);
  s.pressure_gradient[along] = -1;
  s.side[2 * along].clear(), s.side[2 * along + 1].clear();
  Vec3 centre{0, 0, 0}, axis{0, 0, 0};
  axis[along] = 1;
  centre[e] = 0.5 + (random_number(2 * salt) - 0.5) / N, centre[f] = 0.5 + (random_number(2 * salt + 1) - 0.5) / N;
  s.bodies = {body(std::make_shared<CylinderShape>(centre, axis, R, FluidIs::kInside), "pipe")};
  if (r > 0) s.bodies.push_back(body(std::make_shared<CylinderShape>(centre, axis, r, FluidIs::kOutside), "rod"));
  std::array<std::vector<double>, 3> nodes;
  std::array<bool, 3> periodic{false, false, false};
  periodic[along] = true;
  nodes[e] = uniform(0, 1, N), nodes[f] = uniform(0, 1, N), nodes[along] = uniform(0, 2.0 / N, 2);
  CfdBox box(nodes, periodic, s);
  const int steps = until_steady(box, along, s.dt, 1e-7, 50);
  EXPECT_GT(steps, 0);
  const double core = r > 0 ? (R * R - r * r) * (R * R - r * r) / std::log(R / r) : 0;
  const double error = superficial(box, along) / (kPi / 8 * (std::pow(R, 4) - std::pow(r, 4) - core)) - 1;
  // The walls carry what drives the flow.
  double force = 0;
  for (const BodyForce& b : box.fluid->body_forces()) force += b.force()[along];
  const double balance = force / open_volume(box) - 1;
  report("%s along %d, %.1f cells across, place %d: flow %+.3f %%, force %+.1e, %d steps\n", r > 0 ? "annulus" : "pipe",
         along, N * (r > 0 ? R - r : 2 * R), salt, 100 * error, balance, steps);
  EXPECT_LT(std::abs(balance), 1e-6);
  return error;
}

}  // namespace

TEST(Bodies, Pipe) {
  double coarse = 0;
  for (int along : {0, 1, 2}) {
    for (int salt = 0; salt < 3; ++salt) {
      const double error = std::abs(pipe_error(along, 16, 0.42, 0, salt));
      EXPECT_LT(error, 0.01);
      coarse = std::max(coarse, error);
    }
    const double fine = std::abs(pipe_error(along, 32, 0.42, 0, along));
    EXPECT_LT(fine, 0.003);
    EXPECT_LT(fine, coarse / std::pow(2, 1.8));
  }
}

TEST(Bodies, Annulus) {
  for (int along : {0, 1, 2}) {
    // The places scatter by a twentieth; the fine grid, which takes the time, has one of them.
    double error[2] = {0, 0};
    for (int fine = 0; fine < 2; ++fine) {
      const int places = fine ? 1 : 4;
      for (int salt = 0; salt < places; ++salt) {
        const double e = pipe_error(along, fine ? 60 : 30, 0.42, 0.357 * 0.42, 7 * (salt + fine * along) + along);
        error[fine] += e * e / places;
      }
    }
    EXPECT_LT(std::sqrt(error[0]), 0.015);
    EXPECT_GT(0.5 * std::log2(error[0] / error[1]), 1.8);
  }
}

namespace {

/// mu = 1/(1 + a r^2) in cells whose centre lies in the pipe; beyond them what no fluid may feel.
struct ViscosityInPipe : FluidModel {
  int along;
  Vec3 centre;
  double R, a;
  void properties(const FluidDomain& domain, const FluidState&, const FaceField<FineGrid>&,
                  FluidProperties& properties) override {
    auto& field = properties.viscosity.vary(domain.local);
    for_each(domain.own, [&](int i, int j, int k) {
      double r2 = 0;
      for (int d = 0; d < 3; ++d)
        if (d != along) r2 += std::pow(domain.grid.axis[d].centre(Int3{i, j, k}[d]) - centre[d], 2);
      field(i, j, k) = domain.measures.open()->theta()(i, j, k) > 0 ? 1 / (1 + a * r2) : 1e-4;
    });
  }
};

struct Layers : FluidModel {
  int across;
  double h, mu1, mu2;
  Layers(int d, double height, double below, double above) : across(d), h(height), mu1(below), mu2(above) {}
  void properties(const FluidDomain& domain, const FluidState&, const FaceField<FineGrid>&,
                  FluidProperties& properties) override {
    auto& field = properties.viscosity.vary(domain.local);
    for_each(domain.own, [&](int i, int j, int k) {
      field(i, j, k) = domain.grid.axis[across].centre(Int3{i, j, k}[across]) < h ? mu1 : mu2;
    });
  }
};

}  // namespace

/// du/dr = -G r (1 + a r^2)/2: the flow rate is pi G (R^4/8 + a R^6/12). On a graded grid, too.
TEST(Bodies, PipeOfVaryingViscosity) {
  for (double graded : {1.0, 1.03})
    for (int along : {0, 1, 2}) {
      double error[2];
      for (int fine = 0; fine < 2; ++fine) {
        const int N = fine ? 32 : 16, e = (along + 1) % 3, f = (along + 2) % 3;
        const double R = 0.42, a = 40;
        FluidSettings s = creeping(10);
        s.pressure_gradient[along] = -1;
        s.side[2 * along].clear(), s.side[2 * along + 1].clear();
        auto model = std::make_unique<ViscosityInPipe>();
        model->along = along, model->R = R, model->a = a;
        model->centre[e] = 0.5 + 0.3 / N, model->centre[f] = 0.5 - 0.4 / N, model->centre[along] = 0;
        Vec3 axis{0, 0, 0};
        axis[along] = 1;
        s.bodies = {body(std::make_shared<CylinderShape>(model->centre, axis, R, FluidIs::kInside), "pipe")};
        std::array<std::vector<double>, 3> nodes;
        std::array<bool, 3> periodic{false, false, false};
        periodic[along] = true;
        const double ratio = fine ? std::sqrt(graded) : graded;
        nodes[e] = graded_nodes(0, 1, N, ratio), nodes[f] = graded_nodes(0, 1, N, 1 / ratio),
        nodes[along] = uniform(0, 2.0 / N, 2);
        CfdBox box(nodes, periodic, s);
        box.fluid->add_model(std::move(model));
        EXPECT_GT(until_steady(box, along, s.dt, 1e-7, 50), 0);
        const double exact = kPi * (std::pow(R, 4) / 8 + a * std::pow(R, 6) / 12);
        error[fine] = std::abs(superficial(box, along) / exact - 1);
        const double force = box.fluid->body_forces()[0].force()[along];
        EXPECT_NEAR(force / open_volume(box), 1, 1e-6);
      }
      report("pipe of varying viscosity along %d, cells graded by %.2f: %.3f %%, %.3f %%, order %.2f\n", along, graded,
             100 * error[0], 100 * error[1], std::log2(error[0] / error[1]));
      EXPECT_GT(std::log2(error[0] / error[1]), graded == 1 ? 1.8 : 1.7);
      EXPECT_LT(error[1], graded == 1 ? 0.006 : 0.008);
    }
}

/// Two layers of different viscosity in a duct along the grid whose walls lie anywhere in graded cells: the sides between
/// cells of both must have the conductance of the two in series, and the walls the viscosity of the cell beside them.
TEST(Bodies, LayersBetweenWalls) {
  for (int along : {0, 1, 2}) {
    const int across = (along + 1) % 3, thin = (along + 2) % 3;
    double error[2];
    for (int fine = 0; fine < 2; ++fine) {
      const int N = fine ? 32 : 16;
      const double lo = 0.071, hi = 0.93, mu1 = 4, mu2 = 0.5;
      FluidSettings s = creeping(10);
      s.pressure_gradient[along] = -1;
      s.side[2 * along].clear(), s.side[2 * along + 1].clear();
      Vec3 normal{0, 0, 0}, low{0, 0, 0}, high{0, 0, 0};
      normal[across] = 1, low[across] = lo, high[across] = hi;
      s.bodies = {body(std::make_shared<PlaneShape>(low, normal), "low")};
      normal[across] = -1;
      s.bodies.push_back(body(std::make_shared<PlaneShape>(high, normal), "high"));
      std::array<std::vector<double>, 3> nodes;
      std::array<bool, 3> periodic{false, false, false};
      periodic[along] = true;
      nodes[along] = uniform(0, 0.25, 2), nodes[thin] = uniform(0, 0.1, 1);
      nodes[across] = graded_nodes(0, 1, N, fine ? std::sqrt(1.1) : 1.1);
      CfdBox box(nodes, periodic, s);
      const double h = nodes[across][N / 2];
      box.fluid->add_model(std::make_unique<Layers>(across, h, mu1, mu2));
      EXPECT_GT(until_steady(box, along, s.dt, 1e-8, 50), 0);
      // tau = c - y from the lower wall, u = 0 at both.
      const double H = hi - lo, m = h - lo,
                   c = (m * m / (2 * mu1) + (H * H - m * m) / (2 * mu2)) / (m / mu1 + (H - m) / mu2);
      const auto below = [&](double y) { return (c * y * y / 2 - y * y * y / 6) / mu1; };
      const auto above = [&](double y) { return (c * (y * y / 2 - H * y) - (y * y * y / 6 - H * H * y / 2)) / mu2; };
      const double exact = below(m) + above(H) - above(m);
      error[fine] = superficial(box, along) / exact - 1;
    }
    report("two layers between walls along %d: flow %+.3f %%, %+.3f %%\n", along, 100 * error[0], 100 * error[1]);
    EXPECT_LT(std::abs(error[1]), 0.003);
    EXPECT_LT(std::abs(error[1]), std::abs(error[0]) / 3);
  }
}
