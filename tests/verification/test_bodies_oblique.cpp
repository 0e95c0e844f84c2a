// Flows along ducts at an angle to the grid: against parallel flow's formulas, with friction at the walls and without.
// Without these, walls that hold the fluid back more at one angle than at another, fluid that slivers brake, or momentum
// that convection loses to walls would pass.
#include <gtest/gtest.h>

#include "tests/verification/oblique_ducts.h"

using namespace twogrid;

namespace {

/// Error of the flow rate of Poiseuille flow; density 0: creeping. u: what a flow with inertia begins with, and the flow that
/// comes out.
double oblique_duct(int thin, int N, double degrees, int salt, double density = 0,
                    Convection scheme = Convection::kCentral, FaceField<FineGrid>* u = nullptr) {
  Duct duct(thin, N, degrees, salt);
  const int x = duct.x, y = duct.y;
  const double half = duct.half, sine = duct.sine, cosine = duct.cosine;
  if (density > 0) {
    duct.s.density = density;
    duct.s.convection = scheme;
    duct.s.dt = 0, duct.s.cfl = 0.6;
  }
  CfdBox box = duct.box();
  if (density > 0) box.fluid->set_state(0, *u, box.fluid->pressure(), box.eps_begin, 1, *u, box.eps_begin);
  // Of an interval with inertia, a fifteenth of the change is left for the next one.
  const int steps =
      until_steady(box, x, density > 0 ? 0.1 * density : 10, density > 0 ? 1e-4 : 1e-6, density > 0 ? 12 : 60);
  EXPECT_GT(steps, 0);
  const double U = 2.0 / 3 * half * half * half, error = std::hypot(superficial(box, x), superficial(box, y)) / U - 1,
               across = superficial(box, x) * sine - superficial(box, y) * cosine;
  report("duct across %d at %.1f degrees, %.1f cells across, density %g: flow %+.3f %%, across it %.1e, %d steps\n",
         thin, degrees, 2 * half * N, density, 100 * error, across / U, steps);
  EXPECT_LT(std::abs(across), 1e-5 * U);
  if (u) *u = box.fluid->velocity();
  return error;
}

/// Root mean square of the errors in some places of the grid.
double scatter(int thin, int N, double degrees, int places) {
  double sum = 0;
  for (int salt = 0; salt < places; ++salt) {
    const double error = oblique_duct(thin, N, degrees, 10 * salt + thin);
    sum += error * error;
  }
  return std::sqrt(sum / places);
}

}  // namespace

TEST(BodiesAtAnAngle, DuctsAreOfSecondOrder) {
  for (double degrees : {45.0, 30.0, 20.0})
    for (int thin : {0, 1, 2}) {
      if (degrees != 30 && thin != (degrees > 30)) continue;  // one of the directions will do
      const double coarse = scatter(thin, 12, degrees, 4), fine = scatter(thin, 24, degrees, 4),
                   order = std::log2(coarse / fine);
      report("duct at %.0f degrees across %d: %.3f %%, %.3f %%, order %.2f\n", degrees, thin, 100 * coarse, 100 * fine,
             order);
      EXPECT_GT(order, 1.8);
      EXPECT_LT(fine, 0.005);
    }
}

/// Convection leaves parallel flow as it is (Reynolds number 80 by the mean velocity and the duct's width).
TEST(BodiesAtAnAngle, ConvectionInADuct) {
  for (double degrees : {30.0})
    for (int N : {12, 24})
      for (Convection scheme : {Convection::kCentral, Convection::kVanLeer}) {
        FaceField<FineGrid> u;
        const double still = oblique_duct(2, N, degrees, 2, 0, scheme, &u),
                     fast = oblique_duct(2, N, degrees, 2, 3000, scheme, &u);
        report("convection %d at %.0f degrees, %.1f cells across: loses %.3f %%\n", int(scheme), degrees, 0.6 * N,
               100 * (still - fast));
        // van Leer's limiter takes its share in flow at an angle to the grid without walls, too.
        const double most = scheme == Convection::kCentral ? (N == 12 ? 0.015 : 2e-3) : N == 12 ? 0.09 : 0.015;
        EXPECT_NEAR(fast, still, most);
      }
}

/// A plug along slip walls goes on as it is: nothing rubs, nothing holds slivers back.
TEST(BodiesAtAnAngle, PlugAlongSlipWalls) {
  for (double degrees : {45.0, 30.0})
    for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
      for (Choice implicit : {Choice::kOff, Choice::kOn}) {
        Duct duct(2, 16, degrees, 3);
        const Vec3 U{duct.cosine, duct.sine, 0};
        FluidSettings& s = duct.s;
        s.viscosity = 1e-3, s.convection = scheme, s.implicit_viscosity = implicit;
        s.dt = 0.01, s.pressure_rtol = 1e-12;
        s.pressure_gradient = {0, 0, 0};
        s.initial_velocity = U;
        s.bodies[0].slip = true;
        CfdBox box = duct.box();
        for (int n = 0; n < 100; ++n) box.step(s.dt);
        double apart = 0, mean[2] = {0, 0};
        for (int d : {0, 1})
          for_each(box.faces(d), [&](int i, int j, int k) {
            if (box.fluid->face_state(d)(i, j, k) != FaceState::kSolved) return;
            const double change = box.fluid->velocity()[d](i, j, k) - U[d],
                         V = box.fluid->measures().open_volume(d, i, j, k);
            apart = std::max(apart, std::abs(change)), mean[0] += change * U[d] * V, mean[1] += U[d] * U[d] * V;
          });
        const double lost = box.sum(mean[0]) / box.sum(mean[1]);
        apart = box.largest(apart);
        const Vec3 force = box.fluid->body_forces()[0].force();
        report("plug at %.0f degrees, convection %d, implicit %d: lost %.1e, apart %.1e, force %.1e\n", degrees,
               int(scheme), int(implicit), lost, apart, std::hypot(force[0], force[1]));
        // At 30 degrees faces of all open shares occur: slivers lag behind, and the plug loses some of its momentum.
        EXPECT_LT(std::abs(lost), degrees == 45 ? 1e-12 : 0.025);
        EXPECT_LT(apart, degrees == 45 ? 1e-11 : 0.45);
      }
}
