// A viscosity that a model gives a cell. Without these tests it could be taken from the wrong level or cell, miss its
// halo between ranks or its ghosts at walls, or leave the fluid's step bounded by the number in the script.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

/// mu by the coordinate in direction d.
struct ViscosityAlong : FluidModel {
  int d;
  std::function<double(double)> mu;
  void properties(const FluidDomain& domain, const FluidState&, const FaceField<FineGrid>&,
                  FluidProperties& properties) override {
    auto& field = properties.viscosity.vary(domain.local);
    for_each(domain.own, [&](int i, int j, int k) {
      field(i, j, k) = mu(domain.grid.axis[d].centre(Int3{i, j, k}[d]));
    });
  }
};

std::unique_ptr<FluidModel> viscosity_along(int d, std::function<double(double)> mu) {
  auto model = std::make_unique<ViscosityAlong>();
  model->d = d, model->mu = std::move(mu);
  return model;
}

}  // namespace

TEST(ViscosityField, OfOneValueIsTheNumber) {
  // Vortices between walls in an uneven void fraction; explicit and implicit.
  for (Choice implicit : {Choice::kOff, Choice::kOn}) {
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.01, s.initial_vortex = 1, s.implicit_viscosity = implicit;
    s.side[kZlo] = s.side[kZhi] = {condition(BoundaryKind::kNoSlip)};
    const std::array<std::vector<double>, 3> nodes{uniform(0, 1, 12), uniform(0, 1, 10), graded_nodes(0, 0.5, 6, 1.1)};
    CfdBox number(nodes, {true, true, false}, s), field(nodes, {true, true, false}, s);
    field.fluid->add_model(viscosity_along(2, [](double) { return 0.01; }));
    double worst = 0, largest = 0;
    for (int k = 0; k < 6; ++k) {
      for (CfdBox* box : {&number, &field}) {
        box->set(box->eps_end, [&](double x, double y, double z) {
          return 0.7 +
                 0.1 * std::sin(6.283185307179586 * (x - 0.02 * (k + 1))) * std::cos(6.283185307179586 * y) * (1 + z);
        });
        box->step(0.05);
        box->eps_begin = box->eps_end;
      }
      for (int d = 0; d < 3; ++d)
        for_each(number.faces(d), [&](int i, int j, int l) {
          const double a = number.fluid->velocity()[d](i, j, l), b = field.fluid->velocity()[d](i, j, l);
          worst = std::max(worst, std::abs(a - b)), largest = std::max(largest, std::abs(a));
        });
    }
    worst = number.largest(worst), largest = number.largest(largest);
    report("viscosity of one value as a field, %s: largest difference %.1e of %.2f m/s\n",
           implicit == Choice::kOn ? "implicit" : "explicit", worst, largest);
    // Implicit: to the tolerance of its solver.
    EXPECT_LT(worst, (implicit == Choice::kOn ? 1e-8 : 1e-11) * largest);
    EXPECT_GT(largest, 0.3);
  }
}

TEST(ViscosityField, TwoLayersBetweenPlates) {
  // -G = 2 Pa/m drives layers of mu_1 (below h) and mu_2 between plates at 0 and 1. From d(tau)/dy = -2: tau = c - 2 y,
  // u = (c y - y^2)/mu_1 below, u = (c (y - 1) - (y^2 - 1))/mu_2 above; u is continuous at h.
  const double mu1 = 4, mu2 = 0.5, h = 0.25;
  const double c = (h * h / mu1 + (1 - h * h) / mu2) / (h / mu1 + (1 - h) / mu2);
  const auto exact = [&](double y) { return y < h ? (c * y - y * y) / mu1 : (c * (y - 1) - (y * y - 1)) / mu2; };
  for (int along : {0, 1, 2})
    for (bool implicit : {true, false}) {
      if (!implicit && along != 1) continue;  // many steps
      const int across = (along + 1) % 3, thin = (along + 2) % 3;
      double error[2];
      for (int level = 0; level < 2; ++level) {
        const int n = level == 0 ? 8 : 16;
        FluidSettings s;
        s.density = 1;
        s.viscosity = 1e-3;  // a step bounded by it would be far too long for explicit terms
        s.pressure_gradient[along] = -2;
        s.implicit_viscosity = implicit ? Choice::kOn : Choice::kOff;
        s.dt = implicit ? 0.05 : 0;
        s.side[2 * across] = s.side[2 * across + 1] = {condition(BoundaryKind::kNoSlip)};
        s.side[2 * thin] = s.side[2 * thin + 1] = {condition(BoundaryKind::kSlip)};
        std::array<bool, 3> periodic{false, false, false};
        periodic[along] = true;
        std::array<std::vector<double>, 3> nodes;
        nodes[along] = uniform(0, 1, 2), nodes[across] = uniform(0, 1, n), nodes[thin] = uniform(0, 1, 1);
        CfdBox box(nodes, periodic, s);
        box.fluid->add_model(viscosity_along(across, [=](double y) { return y < h ? mu1 : mu2; }));
        for (int k = 0; k < (implicit ? 60 : 40); ++k) box.step(0.05);
        error[level] = box.face_error(along, [&](double x, double y, double z) {
          const double q[3] = {x, y, z};
          return exact(q[across]);
        });
      }
      report("two layers along %d, %s: error %.3e %.3e, order %.2f\n", along, implicit ? "implicit" : "explicit",
             error[0], error[1], std::log2(error[0] / error[1]));
      EXPECT_GT(std::log2(error[0] / error[1]), 1.9);
      EXPECT_LT(error[1], 2e-3);
    }
}

TEST(ViscosityField, MustBeAboveZero) {
  FluidSettings s;
  s.density = 1, s.viscosity = 1;
  CfdBox box({uniform(0, 1, 4), uniform(0, 1, 4), uniform(0, 1, 4)}, {true, true, true}, s);
  box.fluid->add_model(viscosity_along(0, [](double x) { return x > 0.8 ? -1e-3 : 1.0; }));
  EXPECT_THROW(box.step(0.01), std::runtime_error);
}
