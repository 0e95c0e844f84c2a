// Fluid and particles together in a round vessel that the grid cuts anyhow: a packed bed at rest has Ergun's pressure
// drop over the open section, wherever the vessel's axis lies on the grid. Without it would pass: drag per whole instead
// of open volume, a void fraction that is off in cut nodes, an area that is not the vessel's.
// (Reads by the particle cell: those by fine cells also see the layer of half a diameter at the wall in which no centre
// lies.)
#include <gtest/gtest.h>

#include "cfd/bodies/simple_shapes.h"
#include "cfd/fluid_solver.h"
#include "coupling/coupling.h"
#include "coupling/two_grid/open_nodes.h"
#include "tests/unit/coupling/coupling_fakes.h"
#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kRadius = 10.3e-3, kWidth = 1e-3, kHeight = 16e-3, kDiameter = 0.49e-3, kSpacing = 0.5e-3;
constexpr double kViscosity = 1.8e-5, kDensity = 1.2, kGradient = 2e4;

/// Superficial velocity by Ergun (1952).
double ergun(double eps) {
  const double s = 1 - eps, a = 150 * s * s * kViscosity / (eps * eps * eps * kDiameter * kDiameter),
               b = 1.75 * s * kDensity / (eps * eps * eps * kDiameter);
  return (std::sqrt(a * a + 4 * b * kGradient) - a) / (2 * b);
}

struct Flow {
  double velocity, expected, area;  // superficial, over the open section; area over the circle's
};

enum class Wall { kSampled, kSlip, kNoSlip };  ///< shares by fine sampling, or a cylinder that the solver cuts itself

Flow through_bed(double x0, double y0, Deposit deposit, Read read, Formulation form, Wall wall = Wall::kSampled) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const Int3 ratio{4, 4, 4};
  const FineGrid grid = twogrid_test::make_grid({0, 0, 0}, {24e-3, 24e-3, kHeight}, {24, 24, 16}, {false, false, true});
  const Layout layout = twogrid_test::make_layout(grid, ranks_of(comm), ratio);
  FluidSettings s;
  s.density = kDensity, s.viscosity = kViscosity;
  for (int side = 0; side < 4; ++side) s.side[side] = {condition(BoundaryKind::kSlip)};
  s.pressure_gradient[2] = -kGradient;
  const OpenSpaceModel shares = [&](const FineGrid& g, OpenSpace& space) {
    constexpr int n = 32;
    const auto open = [&](double x, double y) { return std::hypot(x - x0, y - y0) < kRadius; };
    const auto in_cell = [&](int i, int j) {
      int hits = 0;
      for (int b = 0; b < n; ++b)
        for (int a = 0; a < n; ++a) hits += open((i + (a + 0.5) / n) * kWidth, (j + (b + 0.5) / n) * kWidth);
      return double(hits) / (n * n);
    };
    for_each(space.theta.box(), [&](int i, int j, int k) { space.theta(i, j, k) = in_cell(i, j); });
    for (int d = 0; d < 3; ++d)
      for_each(space.alpha[d].box(), [&](int i, int j, int k) {
        double& alpha = space.alpha[d](i, j, k);
        if (d == 2) {
          alpha = in_cell(i, j);
          return;
        }
        int hits = 0;
        for (int a = 0; a < n; ++a)
          hits +=
              d == 0 ? open(i * kWidth, (j + (a + 0.5) / n) * kWidth) : open((i + (a + 0.5) / n) * kWidth, j * kWidth);
        const Int3 below{i - (d == 0), j - (d == 1), k};
        const bool between = below[d] >= 0 && Int3{i, j, k}[d] < g.n()[d];
        alpha = between && in_cell(i, j) > 0 && in_cell(below[0], below[1]) > 0 ? double(hits) / n : 0.0;
      });
  };
  if (wall == Wall::kSampled)
    s.open_space = shares;
  else
    s.bodies = {{"vessel", std::make_shared<CylinderShape>(Vec3{x0, y0, 0}, Vec3{0, 0, 1}, kRadius, FluidIs::kInside),
                 wall == Wall::kSlip}};
  FluidSolver fluid(comm, grid, layout, s);

  twogrid_test::Bodies all;
  const int m = int(kRadius / kSpacing) + 1;
  for (int k = 0; k < 32; ++k)
    for (int j = -m; j <= m; ++j)
      for (int i = -m; i <= m; ++i) {
        const double x = i * kSpacing, y = j * kSpacing;
        if (std::hypot(x, y) > kRadius - 0.5 * kDiameter) continue;
        all.add({x0 + x * std::cos(0.3) - y * std::sin(0.3), y0 + x * std::sin(0.3) + y * std::cos(0.3),
                 (k + 0.5) * kSpacing},
                0.5 * kDiameter, 1e9, {0, 0, 0}, int(all.x.size()) + 1);
      }
  twogrid_test::Bodies mine = twogrid_test::share_of(all, grid, comm);
  Particles p = mine.view();
  Settings settings;
  settings.id = "gas";
  settings.fluid = s;
  settings.fine = grid.n(), settings.ratio = ratio;
  settings.drag = "ergun";
  settings.deposit = deposit, settings.read = read, settings.formulation = form;
  settings.kernel_width = settings.cube_edge = 4e-3;
  const ParticleRegion region = twogrid_test::make_region(grid, comm, 1e-4);
  Coupling coupling(comm, settings, fluid, region.lo, region.hi, region.reach);
  const double dt = 2e-4;
  coupling.start(p, dt);
  coupling.force(p, dt, false);
  for (int n = 0; n < 14; ++n) {
    coupling.advance(p, 1, dt);
    for (auto& f : mine.f) f = {0, 0, 0};
    for (auto& v : mine.v) v = {0, 0, 0};
    coupling.force(p, dt, true);
  }
  EXPECT_LE(coupling.report().solid_volume_error, 1e-13);
  EXPECT_EQ(coupling.report().particles, (long long)all.x.size());
  EXPECT_EQ(coupling.report().in_walls, 0);
  EXPECT_EQ(coupling.in_closed_cells(p), 0);
  EXPECT_GT(coupling.open_nodes()->figures().merged, 0);
  double sums[2] = {0, 0}, total[2];
  for_each(layout.faces(2, rank_of(comm)), [&](int i, int j, int k) {
    sums[0] += fluid.flux(2, i, j, k) * grid.area(2, i, j, k) * grid.axis[2].face_width(k);
  });
  for_each(layout.cells(rank_of(comm)),
           [&](int i, int j, int k) { sums[1] += fluid.open_shares()->theta()(i, j, k) * grid.volume(i, j, k); });
  MPI_Allreduce(sums, total, 2, MPI_DOUBLE, MPI_SUM, comm);
  const double eps = 1 - double(all.x.size()) * sphere_volume(0.5 * kDiameter) / total[1];
  return {total[0] / total[1], ergun(eps), total[1] / (3.14159265358979323846 * kRadius * kRadius * kHeight)};
}

}  // namespace

TEST(BedInVessel, PackedBedHasErgunsDropWhereverTheAxisLies) {
  double least = 1e300, most = 0;
  const bool one = ranks_of(MPI_COMM_WORLD) == 1;  // on several ranks one of each kind will do
  for (const auto& at : {std::array<double, 2>{12e-3, 12e-3}, {12.3e-3, 11.6e-3}, {11.2e-3, 12.9e-3}}) {
    const Flow f = through_bed(at[0], at[1], Deposit::kTrilinear, Read::kTrilinear, Formulation::kB);
    report("axis at %.1f %.1f mm: U %.5f, Ergun %.5f m/s (%+.2f %%), section %.5f of the circle's\n", 1e3 * at[0],
           1e3 * at[1], f.velocity, f.expected, 100 * (f.velocity / f.expected - 1), f.area);
    EXPECT_NEAR(f.area, 1, 1e-3);
    EXPECT_NEAR(f.velocity / f.expected, 1, 0.01);
    least = std::min(least, f.velocity), most = std::max(most, f.velocity);
    if (!one) break;
  }
  EXPECT_LT(most / least, 1.01);
  struct Other {
    Deposit deposit;
    Read read;
    Formulation form;
  };
  for (const Other& o : {Other{Deposit::kTrilinear, Read::kTrilinear, Formulation::kA},
                         {Deposit::kExact, Read::kCell, Formulation::kB},
                         {Deposit::kCube, Read::kTrilinear, Formulation::kB}}) {
    const Flow f = through_bed(12.3e-3, 11.6e-3, o.deposit, o.read, o.form);
    report("deposit %d, read %d: U %.5f, Ergun %.5f m/s (%+.2f %%)\n", int(o.deposit), int(o.read), f.velocity,
           f.expected, 100 * (f.velocity / f.expected - 1));
    EXPECT_NEAR(f.velocity / f.expected, 1, 0.01);
    if (!one) break;
  }
  // The solver's own cut: a polygon, a little smaller than the circle. Friction of the wall is felt in its cells alone.
  for (Wall wall : {Wall::kNoSlip, Wall::kSlip}) {
    const Flow f = through_bed(12.3e-3, 11.6e-3, Deposit::kTrilinear, Read::kTrilinear, Formulation::kB, wall);
    report("cylinder, %s: U %.5f, Ergun %.5f m/s (%+.2f %%), section %.5f of the circle's\n",
           wall == Wall::kSlip ? "slip" : "no slip", f.velocity, f.expected, 100 * (f.velocity / f.expected - 1),
           f.area);
    EXPECT_NEAR(f.area, 1, 5e-3);
    EXPECT_NEAR(f.velocity / f.expected, 1, 0.01);
    if (!one) break;
  }
}
