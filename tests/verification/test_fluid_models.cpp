// What a model of the fluid finds after a step: the fluxes and the void fractions of that step, with which continuity
// holds. Without this test the call could come before the state is that of the step's end, or a checked interval could
// carry a model's field twice over the same time.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

/// eps c carried by the step's own fluxes, first order upwind: c(t^{n+1}) by d(eps c)/dt from the same levels as
/// d(eps)/dt, so that a uniform c stays uniform as far as continuity holds.
struct Carried : FluidModel {
  int field;
  std::array<CellField<FineGrid>, 2> before;  // c^n, c^{n-1}
  int steps = 0;
  void step(const FluidDomain& domain, const Step& step, FluidState& state) override {
    ++steps;
    CellField<FineGrid>& c = state.fields[field].values;
    domain.extend(c);
    if (before[0].size() == 0) before[0] = before[1] = c;
    const CellField<FineGrid> now = c;
    for_each(domain.own, [&](int i, int j, int k) {
      double out = 0;
      for (int d = 0; d < 3; ++d)
        for (int high : {0, 1}) {
          Int3 f{i, j, k}, other{i, j, k};
          f[d] += high, other[d] += high ? 1 : -1;
          const double flux = (high ? 1 : -1) * state.eps_f[d](f[0], f[1], f[2]) * state.u[d](f[0], f[1], f[2]) *
                              domain.measures.area(d, f[0], f[1], f[2]);
          out += flux * (flux > 0 ? now(i, j, k) : now(other[0], other[1], other[2]));
        }
      const double history =
          step.a1 * state.eps[1](i, j, k) * now(i, j, k) + step.a2 * state.eps[2](i, j, k) * before[1](i, j, k);
      c(i, j, k) =
          (-history - step.dt * out / domain.measures.cell_volume(i, j, k)) / (step.a0 * state.eps[0](i, j, k));
    });
    before[1] = now;
  }
};

}  // namespace

TEST(FluidModels, CarryAUniformScalarUniformlyWhileTheVoidFractionChanges) {
  FluidSettings s;
  s.density = 1.2, s.viscosity = 1e-3, s.pressure_rtol = 1e-11;
  s.side[kZlo] = {condition(BoundaryKind::kInlet)}, s.side[kZlo][0].velocity = {0, 0, 0.5};
  s.side[kZhi] = {condition(BoundaryKind::kPressure)};
  CfdBox box({uniform(0, 1, 8), graded_nodes(0, 1, 6, 1.1), uniform(0, 1, 10)}, {true, true, false}, s);
  auto model = std::make_unique<Carried>();
  Carried& carried = *model;
  const int field = carried.field = box.fluid->add_field("scalar", "1", 2.5);
  box.fluid->add_model(std::move(model));
  ASSERT_EQ(box.fluid->model_fields().size(), 1u);
  EXPECT_EQ(box.fluid->model_fields()[0].name, "scalar");
  int steps = 0;
  for (int n = 1; n <= 10; ++n) {
    box.set(box.eps_end, [n](double x, double y, double z) {
      return 0.7 + 0.15 * std::sin(2 * M_PI * (x + 0.05 * n)) * std::cos(2 * M_PI * y) * std::sin(3 * z);
    });
    steps += box.step(0.02).steps;
    box.eps_begin = box.eps_end;
  }
  EXPECT_EQ(carried.steps, steps);
  double worst = 0;
  const auto& c = box.fluid->state().fields[field].values;
  for_each(box.own(), [&](int i, int j, int k) { worst = std::max(worst, std::abs(c(i, j, k) - 2.5)); });
  EXPECT_LT(box.largest(worst), 1e-8);
}

TEST(FluidModels, AreNotCarriedOnByACheck) {
  FluidSettings s;
  s.density = 1.2, s.viscosity = 1e-2, s.initial_vortex = 1;
  struct Counter : FluidModel {
    void step(const FluidDomain&, const Step& step, FluidState& state) override {
      for (std::size_t m = 0; m < state.fields[0].values.size(); ++m) state.fields[0].values.data()[m] += step.dt;
    }
  };
  CfdBox box({uniform(0, 1, 8), uniform(0, 1, 8), uniform(0, 1, 4)}, {true, true, true}, s);
  box.fluid->add_field("age", "s", 0);
  box.fluid->add_model(std::make_unique<Counter>());
  VoidFractionInTime path;
  path.begin = &box.eps_begin, path.end = &box.eps_end;
  for (int n = 0; n < 4; ++n) box.fluid->advance_and_check(0.05, path, {});
  double worst = 0;
  const auto& age = box.fluid->state().fields[0].values;
  for_each(box.own(), [&](int i, int j, int k) { worst = std::max(worst, std::abs(age(i, j, k) - 0.2)); });
  EXPECT_LT(box.largest(worst), 1e-12);
}
