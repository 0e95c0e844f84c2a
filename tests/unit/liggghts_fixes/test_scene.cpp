// The scene report's numbers, the command line and the progress line.
// What would pass falsely without it: a number of the report that is wrong by a factor (no run depends on it, so that
// nothing else would notice); a PETSc option that reaches LIGGGHTS, which ends on it, or a LIGGGHTS switch that
// doesn't.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "coupling/methods.h"
#include "liggghts_fixes/report/progress.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/script_parser.h"

namespace twogrid {
namespace {

Settings scene() {
  Settings s;
  s.id = "gas";
  choose(*find_method("paper"), 0, s);
  s.domain = {0, 0.04, 0, 0.01, 0, 0.2};
  s.fine = {40, 10, 200};
  s.ratio = {4, 5, 4};
  s.every = 10;
  s.fluid.density = 1.2;
  s.fluid.viscosity = 1.8e-5;
  for (auto& side : s.fluid.side) side.resize(1);
  s.fluid.side[kZlo][0].kind = BoundaryKind::kInlet;
  s.fluid.side[kZlo][0].velocity = {0, 0, 0.9};
  s.fluid.side[kZhi][0].kind = BoundaryKind::kPressure;
  return s;
}

SceneFacts facts() {
  SceneFacts f;
  f.particles = 9240;
  f.d_min = f.d_mean = f.d_max = 1.2e-3;
  f.density = 1000;
  f.gravity = {0, 0, -9.81};
  f.dem_dt = 1e-5;
  f.contact_time = 2e-4;
  return f;
}

bool any_with(const std::vector<std::string>& list, const std::string& part) {
  return std::any_of(list.begin(), list.end(), [&](const std::string& s) { return s.find(part) != std::string::npos; });
}

/// Of a script that gives the conditions at zlo and zhi.
std::string report_of(const Settings& s, const SceneFacts& f) {
  Script script;
  script.settings = s;
  script.side_given = {false, false, false, false, true, true};
  return scene_report(script, fine_grid(s, {false, false, false}), f);
}

TEST(SceneNumbersOf, MinimumFluidisationSolvesErgun) {
  const double d = 1.2e-3, rho_p = 1000, rho = 1.2, mu = 1.8e-5, g = 9.81, e = 0.4;
  const double U = minimum_fluidisation(d, rho_p, rho, mu, g, e);
  const double drop =
      150 * mu * (1 - e) * (1 - e) * U / (e * e * e * d * d) + 1.75 * rho * (1 - e) * U * U / (e * e * e * d);
  EXPECT_NEAR(drop, (rho_p - rho) * g * (1 - e), 1e-9 * drop);
}

TEST(SceneNumbersOf, Definitions) {
  const Settings s = scene();
  const FineGrid grid = fine_grid(s, {false, false, false});
  const SceneNumbers n = scene_numbers(s, grid, facts());
  EXPECT_NEAR(n.h_min, 0.001, 1e-12);
  EXPECT_NEAR(n.h_coarse, 0.004, 1e-12);
  EXPECT_EQ(n.U, 0.9);
  EXPECT_NEAR(n.Re, 1.2 * 0.9 * 1.2e-3 / 1.8e-5, 1e-9);
  EXPECT_NEAR(n.Stokes, 1000 * 0.9 * 1.2e-3 / (9 * 1.8e-5), 1e-6);
  // In a bed that is just fluidised the drag (B: over eps) carries the buoyant weight: tau of A's drag is
  // U / (eps g') / eps with slip U/eps, that is rho_p/(rho_p - rho_f) U_mf/(eps^2 g).
  EXPECT_NEAR(n.tau, 1000 / (1000 - 1.2) * n.Umf / (0.4 * 0.4 * 9.81), 1e-3 * n.tau);
  EXPECT_NEAR(n.cfl, 0.9 * 1e-4 / 0.001, 1e-12);
}

TEST(SceneNumbersOf, AutomaticEveryStaysWithinCellsAndResponse) {
  Settings s = scene();
  SceneNumbers n;
  n.h_min = 0.001, n.U = 1, n.tau = 1;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 40);  // cfl 0.4: 4e-4 s
  n.tau = 1e-4;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 5);
  n.tau = 1e-9;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 1);
  // A bed's gas is faster between the grains: 0.6 m/s over the section are 1.5 m/s, 0.4 mm of a cell in 2.67e-4 s.
  n = SceneNumbers();
  n.h_min = 0.001, n.U = 0.6, n.U_bed = 0.6;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 26);
  // Grains that fall at 2 m/s cross 0.3 of 1 mm in 1.5e-4 s.
  n = SceneNumbers();
  n.h_min = n.h_coarse = 0.001, n.v = 2;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 15);
  EXPECT_NE(automatic_every(n, s, 1e-5).why.find("2 m/s"), std::string::npos);
  n = SceneNumbers();
  n.h_min = 1;
  EXPECT_EQ(automatic_every(n, s, 1e-5).steps, 100);
}

TEST(SceneNumbersOf, WhatInletsReachInTheRunCounts) {
  // A ramp that stands at 0 and ends at 0.9 m/s.
  Settings s = scene();
  s.fluid.side[kZlo][0].velocity_now = [] { return Vec3{0, 0, 0}; };
  const FineGrid grid = fine_grid(s, {false, false, false});
  SceneFacts f = facts();
  SceneNumbers n = scene_numbers(s, grid, f);
  EXPECT_TRUE(n.U_varies);
  EXPECT_EQ(n.U, n.Umf);
  f.ahead.side[kZlo] = {0.9};
  n = scene_numbers(s, grid, f);
  EXPECT_EQ(n.U, 0.9);
  EXPECT_TRUE(!n.U_varies && n.U_ahead);
  f.ahead.side[kZlo] = {NAN};
  EXPECT_TRUE(scene_numbers(s, grid, f).U_varies);
}

TEST(SceneNumbersOf, FallingGrains) {
  // Terminal: 18 mu v d^-2 (1 + 0.15 Re^0.687) = rho' g. 1.2 mm in air: 6.0 m/s, more than the fall through 0.2 m, sqrt(2 g 0.2).
  const Settings s = scene();
  const SceneFacts f = facts();
  EXPECT_NEAR(scene_numbers(s, fine_grid(s, {false, false, false}), f).v, std::sqrt(2 * 9.81 * 0.2), 1e-9);
  const double v = scene_numbers(s, fine_grid(s, {false, false, true}), f).v, Re = 1.2 * v * 1.2e-3 / 1.8e-5;
  EXPECT_NEAR(18 * 1.8e-5 * v / (1.2e-3 * 1.2e-3) * (1 + 0.15 * std::pow(Re, 0.687)), (1000 - 1.2) * 9.81, 1);
}

TEST(SceneWarnings, WallsInsideTheDomain) {
  const Settings s = scene();
  const FineGrid grid = fine_grid(s, {false, false, false});
  SceneFacts f = facts();
  const auto warnings = [&](const WallFacts& wall) {
    f.walls = {wall};
    return scene_warnings(s, grid, f, scene_numbers(s, grid, f));
  };
  WallFacts floor;
  floor.kind = WallFacts::Kind::kPlane, floor.id = floor.wall = "floor", floor.axis = 2, floor.position = 0;
  EXPECT_FALSE(any_with(warnings(floor), "floor"));
  floor.position = 0.01;
  EXPECT_TRUE(any_with(warnings(floor), "zlo 0.01"));
  EXPECT_TRUE(any_with(warnings(floor), "'fix_modify " + s.id + " solid floor wall floor'"));
  floor.position = 0.19;
  EXPECT_TRUE(any_with(warnings(floor), "zhi 0.19"));
  floor.solid = true;
  EXPECT_FALSE(any_with(warnings(floor), "floor"));
  WallFacts mesh;
  mesh.id = "cad", mesh.wall = "steel";
  mesh.bounds = {0, 0, 0, 0.01, 0, 0.2};  // a mesh that lies in the side xlo
  EXPECT_FALSE(any_with(warnings(mesh), "cad"));
  mesh.bounds = {0.01, 0.03, 0, 0.01, 0, 0.05};
  EXPECT_TRUE(any_with(warnings(mesh), "'fix_modify " + s.id + " solid cad mesh cad'"));
  mesh.solid = true;
  EXPECT_FALSE(any_with(warnings(mesh), "cad"));
  // a cylinder around the whole domain (40 x 10 mm), and one that cuts its corners off
  WallFacts tube;
  tube.kind = WallFacts::Kind::kCylinder, tube.id = tube.wall = "tube", tube.axis = 2, tube.radius = 0.021;
  tube.bounds = {0.02 - 0.021, 0.02 + 0.021, 0.005 - 0.021, 0.005 + 0.021, 0, 0.2};
  EXPECT_FALSE(any_with(warnings(tube), "tube"));
  tube.radius = 0.02;
  tube.bounds = {0, 0.04, -0.015, 0.025, 0, 0.2};
  EXPECT_TRUE(any_with(warnings(tube), "solid tube wall tube"));
}

TEST(SceneWarnings, EachHasItsCause) {
  Settings s = scene();
  SceneFacts f = facts();
  const auto warnings = [&] {
    const FineGrid grid = fine_grid(s, {false, false, false});
    return scene_warnings(s, grid, f, scene_numbers(s, grid, f));
  };
  EXPECT_TRUE(warnings().empty());
  f.contact_time = 5e-5;
  EXPECT_TRUE(any_with(warnings(), "timestep"));
  f = facts();
  s.ratio = {1, 1, 1};
  EXPECT_TRUE(any_with(warnings(), "ratio"));
  s = scene();
  s.one_way = true;
  EXPECT_TRUE(any_with(warnings(), "one-way"));
  s = scene();
  s.hold_flux = Choice::kOff;
  s.every = 8000;  // 0.08 s; tau is 0.23 s
  EXPECT_TRUE(any_with(warnings(), "response times"));
  EXPECT_TRUE(any_with(warnings(), "fine cells in one coupling interval"));
}

// Two sizes: which form of formulation B is used is said, and a law for one size is warned of, with those for mixtures.
TEST(SceneReportText, MixturesOfSizes) {
  Settings s = scene();
  SceneFacts f = facts();
  const auto report = [&] { return report_of(s, f); };
  EXPECT_EQ(report().find("as sizes differ"), std::string::npos);
  EXPECT_EQ(report().find("beetstra/poly"), std::string::npos);
  f.d_max = 3 * f.d_min;
  EXPECT_NE(report().find("as sizes differ"), std::string::npos);
  EXPECT_NE(report().find("for mixtures there is 'drag beetstra/poly'"), std::string::npos);
  s.drag = "beetstra/poly";
  EXPECT_EQ(report().find("for mixtures"), std::string::npos);
}

// 9240 spheres of 1.2 mm on 40 x 10 mm2 settle to 34.83 mm; particle cells of 4 mm.
TEST(SceneReportText, ABedThatHoldsFewParticleCells) {
  Settings s = scene();
  SceneFacts f = facts();
  const auto report = [&] { return report_of(s, f); };
  EXPECT_NE(report().find("0.03483 m: drag short by about 3.1 %"), std::string::npos) << report();
  EXPECT_EQ(report().find("holds few particle cells"), std::string::npos);
  choose(*find_method("smooth"), 0, s);
  f.particles = 4620;
  EXPECT_NE(report().find("short by about 9.186 %"), std::string::npos) << report();
  EXPECT_NE(report().find("; lower ratio along gravity, or 'method sharp'"), std::string::npos);
  f.end_told = true;
  EXPECT_EQ(report().find("holds few particle cells"), std::string::npos);
  f.end_told = false;
  s.fine[2] = 50, s.ratio[2] = 1;  // the same cells: there is no ratio to lower
  EXPECT_NE(report().find("; take more fine cells along gravity, by 'fine', or 'method sharp'"), std::string::npos);
  s.fine[2] = 84, f.particles = 3000;  // of 2.38 mm, below two grains
  EXPECT_NE(report().find("; 'method sharp' lacks less"), std::string::npos) << report();
  s.fine[2] = 200, s.ratio[2] = 4;
  f.particles = 1593;  // 6.005 mm, five grains
  EXPECT_NE(report().find("bed's end"), std::string::npos) << report();
  f.particles = 1591;  // 5.998 mm
  EXPECT_EQ(report().find("bed's end"), std::string::npos);
  EXPECT_EQ(report().find("holds few particle cells"), std::string::npos);
  f.particles = 4620;
  f.gravity = {0, 0, 0};
  EXPECT_EQ(report().find("bed's end"), std::string::npos);
}

// A vessel of half the section in its lower 20 mm: 9240 spheres (13.93 cm3 settled) fill 4 cm3 there and 24.83 mm above it.
// A nozzle of 1/16 of the floor at 8 m/s over the bed's mean section of 13.93 cm3/44.83 mm.
TEST(SceneNumbersOf, ABedInAVessel) {
  Settings s = scene();
  s.fluid.side[kZlo][0].velocity = {0, 0, 8};
  SceneFacts f = facts();
  const FineGrid grid = fine_grid(s, {false, false, false});
  EXPECT_NEAR(scene_numbers(s, grid, f).U_bed, 8, 1e-12);
  f.cut.emplace();
  f.cut->open_layers[2].assign(200, 0.4e-6);
  for (int k = 0; k < 20; ++k) f.cut->open_layers[2][k] = 0.2e-6;
  f.open_area[kZlo] = {0.25e-4};
  const double bulk = 9240 * M_PI / 6 * 1.728e-9 / 0.6;
  const SettledBed bed = settled_bed(s, grid, f);
  EXPECT_NEAR(bed.height, 0.02 + (bulk - 4e-6) / 0.4e-3, 1e-12);
  EXPECT_NEAR(bed.cells, bed.height / 0.004, 1e-9);
  EXPECT_NEAR(scene_numbers(s, grid, f).U_bed, 8 * 0.25e-4 / (bulk / bed.height), 1e-12);
  f.gravity = {0, 0, 9.81};  // upside down
  EXPECT_NEAR(settled_bed(s, grid, f).height, bulk / 0.4e-3, 1e-12);
  f.particles = 10000000;
  EXPECT_NEAR(settled_bed(s, grid, f).height, 0.2, 1e-12);
}

TEST(SceneWarnings, NoneAtTheLimitItself) {
  Settings s = scene();
  SceneFacts f = facts();
  s.domain = {0, 0.048, 0, 0.0192, 0, 0.24};  // cells of 1.2, 1.92 and 1.2 mm
  f.d_min = f.d_mean = f.d_max = 1.2e-3;
  s.ratio = {2, 2, 2};  // particle cells of two diameters
  s.deposit = Deposit::kCentroid;
  const auto warned = [&](const char* words) {
    const FineGrid grid = fine_grid(s, {false, false, false});
    return any_with(scene_warnings(s, grid, f, scene_numbers(s, grid, f)), words);
  };
  const char* const rough = "below 2";
  const char* const filled = "below 1: a particle fills it";
  EXPECT_FALSE(warned(rough));
  f.d_max = 1.2001e-3;
  EXPECT_TRUE(warned(rough));
  // Volume of sphere and cell in common: a cell holds one.
  f.d_max = 2.4e-3;
  s.deposit = Deposit::kExact;
  EXPECT_FALSE(warned(filled));
  f.d_max = 2.4001e-3;
  EXPECT_TRUE(warned(filled));
  s.deposit = Deposit::kCube;
  EXPECT_FALSE(warned(filled));
  // Grains of a template that isn't in yet; cells that were chosen before it was there.
  s.deposit = Deposit::kCentroid;
  f.d_max = 1.2e-3, f.d_most = 6e-3;
  EXPECT_TRUE(warned(rough));
  f.chosen_for = 1.2e-3;
  const FineGrid grid = fine_grid(s, {false, false, false});
  EXPECT_TRUE(
      any_with(scene_warnings(s, grid, f, scene_numbers(s, grid, f)), "chosen (auto) for particles up to 0.0012 m"));
  f.chosen_for = 6e-3;
  EXPECT_FALSE(any_with(scene_warnings(s, grid, f, scene_numbers(s, grid, f)), "chosen (auto)"));
}

TEST(SceneWarnings, NoiseOfParticlesThatChangeCellsAtOnce) {
  Settings s = scene();
  SceneFacts f = facts();
  const auto noise = [&] {
    const FineGrid grid = fine_grid(s, {false, false, false});
    return any_with(scene_warnings(s, grid, f, scene_numbers(s, grid, f)), "deposit centroid");
  };
  const FineGrid grid = fine_grid(s, {false, false, false});
  // V_p over 10 steps of 1e-5 s and the smallest side of a particle cell, 4 x 4 mm2
  EXPECT_NEAR(scene_numbers(s, grid, f).noise, M_PI / 6 * 1.728e-9 / (1e-4 * 1.6e-5), 1e-4);
  s.deposit = Deposit::kCentroid;
  EXPECT_FALSE(noise());  // 0.57 of 0.9 m/s
  f.dem_dt = 1e-6;
  EXPECT_TRUE(noise());
  for (const Deposit smooth : {Deposit::kTrilinear, Deposit::kExact}) {
    s.deposit = smooth;
    EXPECT_FALSE(noise());
  }
  s.deposit = Deposit::kCentroid;
  f.still = true;  // nothing changes its cell
  EXPECT_FALSE(noise());
}

TEST(SceneReportText, InletsThatFollowAVariable) {
  Settings s = scene();
  double U = 0;
  s.fluid.side[kZlo][0].velocity_now = [&] { return Vec3{0, 0, U}; };
  SceneFacts f = facts();
  const auto report = [&] { return report_of(s, f); };
  EXPECT_NE(report().find("of minimum fluidisation (an inlet's variable is 0 now)"), std::string::npos);
  EXPECT_NE(report().find("hold for its value now"), std::string::npos);
  U = 2;
  EXPECT_NE(report().find("2 m/s now (variable)"), std::string::npos);
  U = 0, f.density = 0;  // no U_mf either
  EXPECT_NE(report().find("unknown: an inlet's variable is 0 now"), std::string::npos);
  s.fluid.side[kZlo][0].velocity_now = nullptr;
  EXPECT_EQ(report().find("variable"), std::string::npos);
}

TEST(SceneReportText, SkinFarFromTheBest) {
  const Settings s = scene();
  const auto report = [&](double skin, double script = -1) {
    SceneFacts f = facts();
    f.skin = skin * f.d_mean;
    f.script_skin = script < 0 ? -1 : script * f.d_mean;
    return report_of(s, f);
  };
  EXPECT_NE(report(0.1).find("0.1 diameters; 0.25 to 0.7"), std::string::npos);
  EXPECT_NE(report(0.9).find("0.9 diameters; 0.25 to 0.7"), std::string::npos);
  EXPECT_EQ(report(0.4).find("neighbour skin"), std::string::npos);
  EXPECT_NE(report(0.4, 0.1).find("0.4 diameters (the script's is"), std::string::npos);
}

TEST(SceneReportText, SaysGridsSidesAndDefaults) {
  const Settings s = scene();
  const std::string r = report_of(s, facts());
  for (const char* part :
       {"40 x 10 x 200", "10 x 2 x 50", "zlo", "inlet", "pressure 0 Pa", "slip (not given in the script)",
        "U_s/U_mf 2.514", "Re = ", "9240", "not modelled", "20 steps"})
    EXPECT_NE(r.find(part), std::string::npos) << part << "\n" << r;
}

TEST(CommandLine, ParticlesChoosesTheKernel) {
  EXPECT_EQ(split_command_line({"twogrid", "-in", "in.bed"}).particles, "auto");
  const CommandLine c = split_command_line({"twogrid", "-particles", "stock", "-in", "in.bed"});
  EXPECT_EQ(c.particles, "stock");
  EXPECT_EQ(c.liggghts, (std::vector<std::string>{"twogrid", "-in", "in.bed"}));
  EXPECT_THROW(split_command_line({"twogrid", "-particles"}), std::invalid_argument);
}

TEST(CommandLineWords, AreSharedOut) {
  const CommandLine c =
      split_command_line({"twogrid", "-in", "in.jet", "-fluid_pressure_rtol", "1e-12", "-var", "U", "1", "2",
                          "-log_view", "-screen", "none", "-ksp_monitor", "-log", "none", "-var", "x", "-3"});
  EXPECT_EQ(c.liggghts, (std::vector<std::string>{"twogrid", "-in", "in.jet", "-var", "U", "1", "2", "-screen",
                                                  "/dev/null", "-log", "none", "-var", "x", "-3"}));
  EXPECT_EQ(c.petsc,
            (std::vector<std::string>{"twogrid", "-fluid_pressure_rtol", "1e-12", "-log_view", "-ksp_monitor"}));
  EXPECT_TRUE(split_command_line({"twogrid", "-version"}).version);
  EXPECT_THROW(split_command_line({"twogrid", "-inn", "in.jet"}), std::invalid_argument);
  EXPECT_THROW(split_command_line({"twogrid", "-in"}), std::invalid_argument);
  EXPECT_THROW(split_command_line({"twogrid", "in.jet"}), std::invalid_argument);
  EXPECT_THROW(split_command_line({"twogrid", "-partition", "2x1"}), std::invalid_argument);
}

TEST(ProgressLine, ComesWhenDue) {
  Progress p;
  p.begin(100, 1000);
  EXPECT_EQ(p.line(105, 10, 0.1), "");
  EXPECT_EQ(p.line(120, 200, 0.25), "twogrid: t = 0.25 s, 20.0 % of this run done, 1 min 20 s to go");
  EXPECT_EQ(p.line(121, 210, 0.26), "");
  EXPECT_EQ(p.line_within(129, 300, 0.25, 5, 0.26), "");
  EXPECT_EQ(p.line_within(131, 300, 0.25, 20, 0.26),
            "twogrid: t = 0.26 s, within a coupling: 300 fluid steps are 25.0 % of its interval, 1 min 00 s to go");
  EXPECT_EQ(p.line_within(145, 301, 0.5, 4, 0.27), "");  // of a short one nothing is told
  EXPECT_EQ(duration(3725), "1 h 02 min");
  EXPECT_EQ(duration(12.34), "12.3 s");
}

TEST(ProgressLine, SharesAddUp) {
  Shares s;
  s.deposit = 1, s.map = 2, s.fluid = 3, s.output = 0.5, s.force = 0.5;
  const std::string text = shares_text(5, 10, s);
  for (const char* part : {"DEM 30.0 %", "deposit 10.0 %", "map and read 20.0 %", "fluid 30.0 %", "output 5.0 %"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace
}  // namespace twogrid
