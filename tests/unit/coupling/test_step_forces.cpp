// The forces of a DEM step against the exact motion of a sphere that gravity, buoyancy, a pressure force and a linear
// drag act on, m dv/dt = (m - rho_f V) g + F_p + b (u - v): short steps, whose velocities lie between the steps, and
// stiff ones, which have forces of their own for each half kick. Without this test a buoyancy of the wrong sign, a
// pressure force counted as drag in what is written, or half the force before a stiff step would pass: in the tests of
// the whole coupling the fluid's answer makes up for it.
#include <gtest/gtest.h>

#include <cmath>

#include "coupling/forces/step_forces.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kRho = 1000, kMu = 1e-3, kRadius = 1e-4, kSolid = 2500, kEps = 0.8;
constexpr Vec3 kG{1.5, -2, -9.81}, kU{0.02, 0.01, 0.03}, kPressure{3e-8, -1e-8, 2e-8};

/// One sphere in fluid at velocity kU.
struct Scene {
  StepForcesState state;
  const DragLaw& law = *find_drag_law("stokes");
  std::unique_ptr<StepForces> forces;
  Bodies bodies;
  Particles p;
  double m, b;

  Scene(bool pressure, bool groups) {
    bodies.add({0, 0, 0}, kRadius, kSolid, {0.01, -0.02, 0.03}, 1);
    p = bodies.view();
    p.mask = mask;
    m = bodies.mass[0];
    state.pressure_force = state.own_force = pressure;
    b = drag_coefficient(law, kEps, 2 * kRadius, 0.01, kRho, kMu, 1.0) / (pressure ? 1 : kEps);
    double* const s = p.state[0];
    for (int d = 0; d < 3; ++d) {
      p.step[0][kStepVelocity + d] = kU[d];
      s[kPressureForce + d] = pressure ? kPressure[d] : 0;
    }
    p.step[0][kDragCoefficient] = s[kResponse] = b;
    s[kVoidFraction] = kEps, s[kSizeRatio] = 1;
    forces = std::make_unique<StepForces>(state, law, kRho, kMu);
    if (groups)  // the third is not the sphere's
      forces->set_gravity({{2, {0.25 * kG[0], 0.25 * kG[1], 0.25 * kG[2]}},
                           {~0, {0.75 * kG[0], 0.75 * kG[1], 0.75 * kG[2]}},
                           {4, {100, 100, 100}}});
    else
      forces->set_gravity({{~0, kG}});
  }
  int mask[1] = {3};
  double constant_force(int d) const {
    return (m - kRho * sphere_volume(kRadius)) * kG[d] + p.state[0][kPressureForce + d];
  }
  double terminal(int d) const { return kU[d] + constant_force(d) / b; }
  void weigh() {
    for (int d = 0; d < 3; ++d) p.f[0][d] = m * kG[d];
  }
};

TEST(StepForces, ShortStepsAreExact) {
  for (bool pressure : {false, true})
    for (bool groups : {false, true}) {
      Scene s(pressure, groups);
      const double dt = 0.015 * s.m / s.b;  // below what counts as stiff
      for (int n = 0; n < 5; ++n) {
        Vec3 before, impulse;
        for (int d = 0; d < 3; ++d) before[d] = s.p.v[0][d], impulse[d] = s.p.step[0][kImpulse + d];
        s.weigh();
        (*s.forces)(s.p, dt, true, nullptr);
        for (int d = 0; d < 3; ++d) {
          const double slip = before[d] - s.terminal(d), k = s.b * dt / s.m;
          const double after = s.terminal(d) + slip * std::exp(-k);
          const double mean = s.terminal(d) - slip * std::expm1(-k) / k;  // of v over the step
          const double drag = s.b * (kU[d] - mean);
          s.p.v[0][d] += s.p.f[0][d] * dt / s.m;
          EXPECT_NEAR(s.p.v[0][d], after, 1e-13 * std::abs(slip));
          EXPECT_NEAR(s.p.state[0][kDragForce + d], drag, 1e-10 * s.b * std::abs(slip));
          EXPECT_NEAR(s.p.step[0][kImpulse + d] - impulse[d], (drag + s.p.state[0][kPressureForce + d]) * dt,
                      1e-10 * s.b * std::abs(slip) * dt);
        }
      }
    }
}

TEST(StepForces, StiffStepsAreExactAtTheirEndsAndInTheMean) {
  for (bool pressure : {false, true})
    for (double k : {0.3, 3.0, 30.0}) {
      Scene s(pressure, false);
      const double dt = k * s.m / s.b;
      s.weigh();
      (*s.forces)(s.p, dt, false, nullptr);
      s.forces->finish_step(s.p);
      for (int n = 0; n < 4; ++n) {
        Vec3 slip, begin;
        for (int d = 0; d < 3; ++d) {
          begin[d] = s.p.v[0][d], slip[d] = begin[d] - s.terminal(d);
          s.p.v[0][d] += 0.5 * s.p.f[0][d] * dt / s.m;
          // This velocity moves the sphere through the step.
          EXPECT_NEAR(s.p.v[0][d], s.terminal(d) - slip[d] * std::expm1(-k) / k, 1e-12 * std::abs(slip[d]) + 1e-15)
              << "k " << k;
        }
        s.weigh();
        (*s.forces)(s.p, dt, true, nullptr);
        for (int d = 0; d < 3; ++d) {
          s.p.v[0][d] += 0.5 * s.p.f[0][d] * dt / s.m;
          EXPECT_NEAR(s.p.v[0][d], s.terminal(d) + slip[d] * std::exp(-k), 1e-12 * std::abs(slip[d]) + 1e-15)
              << "k " << k;
        }
        s.forces->finish_step(s.p);
      }
    }
}

}  // namespace
}  // namespace twogrid_test
