// The viscous force where mu varies, against the exact div(mu (grad u + grad u^T - 2/3 div u I)) of velocities and
// viscosities that are linear in x, y and z: sum over j of d(mu)/dx_j (G_cj + G_jc - 2/3 div u delta_cj). Without this
// test a viscosity of the wrong cell, or one mean for all directions, would pass wherever mu is the same everywhere.
#include <gtest/gtest.h>

#include <cmath>

#include "cfd/momentum/viscous_stress.h"

using namespace twogrid;

namespace {

constexpr double kGradient[3][3] = {{0.7, -0.4, 0.3}, {0.2, 0.5, -0.6}, {-0.1, 0.9, -0.3}};  // du_c/dx_j

double viscosity(const Vec3& x, const Vec3& slope) {
  return 1 + slope[0] * x[0] + slope[1] * x[1] + slope[2] * x[2];
}

struct Block {
  FineGrid grid;
  Box own, local;
  std::array<Box, 3> inner;  // faces away from the sides

  explicit Block(int n) {
    const double ratio = std::pow(1.5, 1.0 / n);
    grid.axis[0] = Axis(graded_nodes(0, 1, n, ratio), false);
    grid.axis[1] = Axis(graded_nodes(0, 1.2, n + 1, 1 / ratio), false);
    grid.axis[2] = Axis(graded_nodes(0, 0.9, n + 2, ratio), false);
    own = grid.cells(), local = own.grown(2);
    for (auto& f : inner) f = own.grown(-2);
  }
  Vec3 cell(int i, int j, int k) const {
    return {grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)};
  }
};

/// Largest error of the force per volume on inner faces.
double error(int n, const Vec3& slope, bool varies, bool print = false) {
  Block b(n);
  const GridMeasures measures(b.grid, b.own, b.local);
  ViscousTerm term(measures, b.own, b.local, b.inner, {true, true, true});
  Property mu;
  mu.number = 1;
  if (varies)
    for_each(b.local, [&](int i, int j, int k) { mu.vary(b.local)(i, j, k) = viscosity(b.cell(i, j, k), slope); });
  const CellField<FineGrid> eps(b.local, 0.5);
  FaceField<FineGrid> u, force;
  for (int c = 0; c < 3; ++c) {
    u[c].reset(b.local), force[c].reset(b.local);
    for_each(b.local, [&](int i, int j, int k) {
      Vec3 x = b.cell(i, j, k);
      x[c] = b.grid.axis[c].node(Int3{i, j, k}[c]);
      u[c](i, j, k) = kGradient[c][0] * x[0] + kGradient[c][1] * x[1] + kGradient[c][2] * x[2];
    });
  }
  term.add(mu, eps, u, force);
  const double div = kGradient[0][0] + kGradient[1][1] + kGradient[2][2];
  double worst = 0;
  for (int c = 0; c < 3; ++c) {
    double exact = varies ? -2.0 / 3 * div * slope[c] : 0;
    for (int j = 0; j < 3; ++j) exact += varies ? slope[j] * (kGradient[c][j] + kGradient[j][c]) : 0;
    for_each(b.inner[c], [&](int i, int j, int k) {
      worst = std::max(worst, std::abs(force[c](i, j, k) / (0.5 * measures.volume(c, i, j, k)) - exact));
    });
  }
  if (print) std::printf("viscous force, n %d, slopes %g %g %g: error %.2e\n", n, slope[0], slope[1], slope[2], worst);
  return worst;
}

}  // namespace

TEST(ViscousStress, ForceOfALinearViscosity) {
  // Along one axis at a time, and along all of them; the harmonic mean on edges leaves an error of second order.
  for (const Vec3& slope : {Vec3{0.8, 0, 0}, Vec3{0, 0.8, 0}, Vec3{0, 0, 0.8}, Vec3{0.3, 0.6, 0.4}}) {
    const double e1 = error(8, slope, true, true), e2 = error(16, slope, true, true);
    EXPECT_LT(e2, 0.02 * 0.8);
    EXPECT_LT(e2, 0.4 * e1 + 1e-11);
  }
  EXPECT_LT(error(8, {0, 0, 0}, false), 1e-11);
}

TEST(ViscousStress, DiagonalOfAFieldIsThatOfANumber) {
  Block b(8);
  const GridMeasures measures(b.grid, b.own, b.local);
  ViscousTerm term(measures, b.own, b.local, b.inner, {true, true, true});
  Property number, field;
  number.number = 0.3;
  field.vary(b.local).fill(0.3);
  const CellField<FineGrid> eps(b.local, 0.5);
  FaceField<FineGrid> one, other;
  for (auto* f : {&one, &other})
    for (auto& c : *f) c.reset(b.local);
  term.diagonal(number, eps, one), term.diagonal(field, eps, other);
  for (int c = 0; c < 3; ++c)
    for_each(b.inner[c], [&](int i, int j, int k) {
      EXPECT_GT(one[c](i, j, k), 0);
      EXPECT_NEAR(one[c](i, j, k), other[c](i, j, k), 1e-14 * one[c](i, j, k));
    });
}

// The diagonal, which only preconditions, is the operator's: the force on a face that alone has a velocity. Without this
// test it could be any multiple of that, and the solver would only take more iterations.
TEST(ViscousStress, DiagonalIsTheForceOnAFaceThatMovesAlone) {
  Block b(8);
  const GridMeasures measures(b.grid, b.own, b.local);
  ViscousTerm term(measures, b.own, b.local, b.inner, {true, true, true});
  Property mu;
  mu.number = 0.3;
  const CellField<FineGrid> eps(b.local, 0.5);
  FaceField<FineGrid> diagonal, u, force;
  for (auto* f : {&diagonal, &u, &force})
    for (auto& c : *f) c.reset(b.local);
  term.diagonal(mu, eps, diagonal);
  for (int c = 0; c < 3; ++c)
    for (int q = 2; q < 6; ++q) {
      const Int3 x{q, (q + 1) % 4 + 2, 8 - q};
      ASSERT_TRUE(b.inner[c].contains(x[0], x[1], x[2]));
      u[c](x[0], x[1], x[2]) = 1;
      for (auto& f : force) f.fill(0);
      term.add(mu, eps, u, force);
      u[c](x[0], x[1], x[2]) = 0;
      const double own = -force[c](x[0], x[1], x[2]);
      EXPECT_NEAR(diagonal[c](x[0], x[1], x[2]), own, 1e-13 * own) << "direction " << c;
    }
}
