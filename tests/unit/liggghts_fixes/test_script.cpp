// The words of fix twogrid and fix_modify, and what is checked before anything is allocated.
// What would pass falsely without it: a keyword that is read into the wrong member (a run would still run), a default
// that changes, a half-read line that leaves half its changes behind, a change that is accepted after the first run and
// does nothing. Wrong scripts as a user sees them are in tests/system/bad_input.py.
#include <gtest/gtest.h>
#include <mpi.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "cfd/boundary/patches.h"
#include "cfd/parallel/ranks.h"
#include "coupling/methods.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/script_parser.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

const char* const kFix = "fine 8 4 16 ratio 4 2 4 density 1.2 viscosity 1.8e-5 every 10";

Script fix(const std::string& line = kFix) {
  return parse_fix("gas", split(line));
}
void modify(Script& s, const std::string& line, bool started = false) {
  parse_fix_modify(s, split(line), started);
}

BoxFacts box(bool periodic_x = false) {
  BoxFacts b;
  b.bounds = {0, 0.008, 0, 0.004, 0, 0.016};
  b.periodic = {periodic_x, false, false};
  return b;
}

/// The sentence that f throws.
template <class F>
std::string sentence(F&& f) {
  try {
    f();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "no exception";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ScriptFix, EveryKeywordReachesItsMember) {
  const Script s =
      fix("fine 10 20 30 ratio 5 4 3 domain 0 1 2 4 3 6 stretch x 1.1 stretch z symmetric 1.2 density 2 viscosity 3 "
          "every 7");
  EXPECT_EQ(s.settings.id, "gas");
  EXPECT_EQ(s.settings.fine, (Int3{10, 20, 30}));
  EXPECT_EQ(s.settings.ratio, (Int3{5, 4, 3}));
  EXPECT_EQ(s.settings.domain, (std::array<double, 6>{0, 1, 2, 4, 3, 6}));
  EXPECT_TRUE(s.domain_given);
  EXPECT_EQ(s.settings.stretch, (std::array<double, 3>{1.1, 1, 1.2}));
  EXPECT_EQ(s.settings.stretch_symmetric, (std::array<bool, 3>{false, false, true}));
  EXPECT_EQ(s.settings.fluid.density, 2);
  EXPECT_EQ(s.settings.fluid.viscosity, 3);
  EXPECT_EQ(s.settings.every, 7);
  EXPECT_FALSE(s.every_auto);
}

TEST(ScriptFix, EveryAutoAndRatioOneByDefault) {
  const Script s = fix("fine 3 3 3 density 1 viscosity 1 every auto");
  EXPECT_TRUE(s.every_auto);
  EXPECT_EQ(s.settings.ratio, (Int3{1, 1, 1}));
  EXPECT_FALSE(s.domain_given);
}

TEST(ScriptFix, SentencesNameKeywordValueAndWish) {
  const std::string s = sentence([] { fix("fine 8 4 15 ratio 4 2 4 density 1 viscosity 1 every 1"); });
  EXPECT_TRUE(has(s, "ratio") && has(s, "4 in z") && has(s, "15") && has(s, "multiple")) << s;
  EXPECT_TRUE(has(sentence([] { fix("fine 8 4"); }), "end of the line"));
  EXPECT_TRUE(has(sentence([] { fix("density v_rho"); }), "${rho}"));
  EXPECT_TRUE(has(sentence([] { fix("fine 1 1 1 density 1 viscosity 1"); }), "every"));
}

TEST(ScriptModify, EveryKeywordReachesItsMember) {
  Script s = fix();
  modify(s, "drag kochhill formulation A deposit exact prolong linear read kernel 0.002 eps bound clip 0.35");
  modify(s, "interpolate linear hold off one-way yes initial u 1 2 3 cfl 0.7 dt 1e-4 convection central");
  modify(s, "implicit on gap friction on pressure_gradient 0 0 -5 flow_rate y 0.2 tolerance 1e-8");
  modify(s, "output every 20 file bed.h5 fields u eps particles no average from 0.5 drag wenyu");
  const Settings& t = s.settings;
  EXPECT_EQ(t.drag, "wenyu");
  EXPECT_EQ(t.formulation, Formulation::kA);
  EXPECT_EQ(t.deposit, Deposit::kExact);
  EXPECT_EQ(t.prolong, Prolong::kLinear);
  EXPECT_EQ(t.read, Read::kKernel);
  EXPECT_EQ(t.kernel_width, 0.002);
  EXPECT_EQ(t.bound, EpsBound::kClip);
  EXPECT_EQ(t.eps_min, 0.35);
  EXPECT_EQ(t.interpolate, Interpolate::kLinear);
  EXPECT_EQ(t.hold_flux, Choice::kOff);
  EXPECT_TRUE(t.one_way);
  EXPECT_EQ(t.fluid.initial_velocity, (Vec3{1, 2, 3}));
  EXPECT_EQ(t.fluid.cfl, 0.7);
  EXPECT_EQ(t.fluid.dt, 1e-4);
  EXPECT_EQ(t.fluid.convection, Convection::kCentral);
  EXPECT_EQ(t.fluid.implicit_viscosity, Choice::kOn);
  EXPECT_TRUE(t.fluid.gap_friction);
  EXPECT_EQ(t.fluid.pressure_gradient, (Vec3{0, 0, -5}));
  EXPECT_EQ(t.fluid.flow_rate, (Vec3{0, 0.2, 0}));
  EXPECT_EQ(t.fluid.flow_rate_set, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(t.fluid.pressure_rtol, 1e-8);
  EXPECT_EQ(t.output.every, 20);
  EXPECT_EQ(t.output.file, "bed.h5");
  EXPECT_EQ(t.output.fields, (std::vector<std::string>{"u", "eps"}));
  EXPECT_FALSE(t.output.particles);
  EXPECT_EQ(t.output.average_from, 0.5);
  modify(s, "output off deposit cube 0.003 read cube 0.003");
  EXPECT_EQ(s.settings.output.every, 0);
  EXPECT_FALSE(s.settings.output.writes());
  EXPECT_TRUE(s.settings.output.file.empty());
  EXPECT_EQ(s.settings.cube_edge, 0.003);
  EXPECT_EQ(s.settings.read, Read::kCube);
}

// A method's name sets what the literature means by it, whatever was said before; words after it set their part.
TEST(ScriptModify, MethodsByName) {
  Script s = fix();
  EXPECT_EQ(s.settings.method, kDefaultMethod);
  const Method* const usual = find_method(kDefaultMethod);
  ASSERT_TRUE(usual);
  EXPECT_EQ(s.settings.deposit, usual->deposit);
  EXPECT_EQ(s.settings.prolong, usual->prolong);
  EXPECT_EQ(s.settings.read, usual->read);
  modify(s, "prolong linear method paper");
  EXPECT_EQ(s.settings.deposit, Deposit::kCentroid);
  EXPECT_EQ(s.settings.prolong, Prolong::kConstant);
  EXPECT_EQ(s.settings.read, Read::kCell);
  modify(s, "method cube 0.003 eps bound clip 0.35");
  EXPECT_EQ(s.settings.deposit, Deposit::kCube);
  EXPECT_EQ(s.settings.read, Read::kCube);
  EXPECT_EQ(s.settings.cube_edge, 0.003);
  EXPECT_EQ(s.settings.bound, EpsBound::kClip);
  modify(s, "method smooth read cell");
  EXPECT_EQ(s.settings.read, Read::kCell);
  EXPECT_FALSE(s.settings.one_grid);
  modify(s, "method kernel 2e-3");
  EXPECT_EQ(s.settings.kernel_width, 2e-3);
  for (const char* wrong : {"method", "method best", "method cube", "method kernel 0", "method single 3"})
    EXPECT_THROW(modify(s, wrong), std::invalid_argument) << wrong;
}

TEST(ScriptModify, WordsOfEnumsStandForTheirNames) {
  Script s = fix();
  const std::vector<std::pair<std::string, Deposit>> deposits{
      {"centroid", Deposit::kCentroid}, {"trilinear", Deposit::kTrilinear}, {"exact", Deposit::kExact}};
  for (const auto& [word, value] : deposits) {
    modify(s, "deposit " + word);
    EXPECT_EQ(s.settings.deposit, value) << word;
  }
  const std::vector<std::pair<std::string, Read>> reads{{"cell", Read::kCell},
                                                        {"trilinear", Read::kTrilinear},
                                                        {"fine", Read::kFine},
                                                        {"fine/trilinear", Read::kFineTrilinear}};
  for (const auto& [word, value] : reads) {
    modify(s, "read " + word);
    EXPECT_EQ(s.settings.read, value) << word;
  }
  const std::vector<std::pair<std::string, BoundaryKind>> kinds{{"slip", BoundaryKind::kSlip},
                                                                {"noslip", BoundaryKind::kNoSlip},
                                                                {"inlet 1 0 0", BoundaryKind::kInlet},
                                                                {"pressure 3", BoundaryKind::kPressure},
                                                                {"periodic", BoundaryKind::kPeriodic}};
  for (const auto& [words, value] : kinds) {
    Script t = fix();
    modify(t, "boundary xhi " + words);
    EXPECT_EQ(t.settings.fluid.side[kXhi].at(0).kind, value) << words;
  }
}

TEST(ScriptModify, BoundariesAndPatches) {
  Script s = fix();
  modify(s,
         "boundary zlo inlet 0 0 v_U boundary zlo patch jet rect 0.001 0.003 0 0.004 inlet 0 0 20 profile parabolic x");
  modify(
      s,
      "boundary zlo patch hole circle 0.006 0.002 0.001 noslip boundary xlo noslip 0 0.1 0 boundary zhi pressure -2");
  const auto& zlo = s.settings.fluid.side[kZlo];
  ASSERT_EQ(zlo.size(), 3u);
  EXPECT_EQ(zlo[0].kind, BoundaryKind::kInlet);
  EXPECT_EQ(s.names[kZlo][0].velocity.variable[2], "U");
  EXPECT_EQ(zlo[1].name, "jet");
  EXPECT_EQ(zlo[1].shape.kind, PatchShape::Kind::kRectangle);
  EXPECT_EQ(zlo[1].shape.value, (std::array<double, 4>{0.001, 0.003, 0, 0.004}));
  EXPECT_EQ(zlo[1].velocity, (Vec3{0, 0, 20}));
  EXPECT_EQ(zlo[1].profile.shape, InletProfile::Shape::kParabolic);
  EXPECT_TRUE(zlo[1].profile.across[0]);
  EXPECT_FALSE(zlo[1].profile.across[1]);
  EXPECT_EQ(zlo[2].shape.kind, PatchShape::Kind::kCircle);
  EXPECT_EQ(zlo[2].kind, BoundaryKind::kNoSlip);
  EXPECT_EQ(s.settings.fluid.side[kXlo][0].velocity, (Vec3{0, 0.1, 0}));
  EXPECT_EQ(s.settings.fluid.side[kZhi][0].pressure, -2);
}

TEST(ScriptModify, PatchBeforeItsSideKeepsTheSideFirst) {
  Script s = fix();
  modify(s, "boundary zlo patch jet rect 0 0.002 0 0.004 inlet 0 0 5 boundary zlo noslip");
  EXPECT_EQ(s.settings.fluid.side[kZlo][0].kind, BoundaryKind::kNoSlip);
  EXPECT_EQ(s.settings.fluid.side[kZlo][1].name, "jet");
}

TEST(ScriptModify, TableOfAnInlet) {
  const int rank = rank_of(MPI_COMM_WORLD);
  const std::string file = "inlet_table_" + std::to_string(rank) + ".txt";
  std::ofstream(file) << "# x factor\n0 0\n0.004, 1.5\n0.008\t0\n";
  Script s = fix();
  modify(s, "boundary zlo inlet 0 0 2 profile table x " + file);
  const InletProfile& p = s.settings.fluid.side[kZlo][0].profile;
  EXPECT_EQ(p.shape, InletProfile::Shape::kTable);
  EXPECT_EQ(p.coordinate, 0);
  EXPECT_EQ(p.table, (std::vector<std::array<double, 2>>{{0, 0}, {0.004, 1.5}, {0.008, 0}}));
  std::ofstream(file) << "0 0\n0.004 1\n0.003 0\n";
  EXPECT_TRUE(has(sentence([&] { modify(s, "boundary xlo inlet 1 0 0 profile table z " + file); }), "ascending"));
  std::remove(file.c_str());
}

TEST(ScriptModify, WrongLineChangesNothing) {
  Script s = fix();
  EXPECT_TRUE(has(sentence([&] { modify(s, "cfl 0.9 theta 3"); }), "theta"));
  EXPECT_EQ(s.settings.fluid.cfl, FluidSettings().cfl);
}

TEST(ScriptModify, AfterTheFirstRunOnlyVelocitiesAndTimesOfOutput) {
  Script s = fix();
  modify(s, "boundary zlo inlet 0 0 1 boundary zhi pressure 0 output every 10 file a.h5");
  modify(s, "boundary zlo inlet 0 0 2", true);
  EXPECT_EQ(s.names[kZlo][0].velocity.number[2], 2);
  modify(s, "output every 40", true);
  EXPECT_EQ(s.settings.output.every, 40);
  EXPECT_TRUE(has(sentence([&] { modify(s, "boundary zlo noslip", true); }), "first run"));
  EXPECT_TRUE(has(sentence([&] { modify(s, "boundary xlo inlet 1 0 0", true); }), "first run"));
  EXPECT_TRUE(has(sentence([&] { modify(s, "boundary zhi pressure 3", true); }), "first run"));
  EXPECT_TRUE(has(sentence([&] { modify(s, "drag wenyu", true); }), "first run"));
  EXPECT_TRUE(has(sentence([&] { modify(s, "output file b.h5", true); }), "off, every"));
  EXPECT_TRUE(has(sentence([&] { modify(s, "output average from 1", true); }), "no means"));
  Script m = fix();
  modify(m, "output every 10 file a.h5 average from 1");
  modify(m, "output average from auto until 0.1", true);
  EXPECT_TRUE(m.settings.output.average_auto);
  EXPECT_EQ(m.settings.output.average_said, 1);
  modify(m, "output off", true);
  EXPECT_TRUE(m.settings.output.writes());
  EXPECT_TRUE(has(sentence([&] {
                    Script none = fix();
                    modify(none, "output every 10", true);
                  }),
                  "before the first run"));
}

TEST(ScriptComplete, DomainAndSidesComeFromTheBox) {
  Script s = fix();
  complete(s, box(true));
  EXPECT_EQ(s.settings.domain, box().bounds);
  EXPECT_EQ(periodic_directions(s.settings.fluid), (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(s.settings.fluid.side[kYlo][0].kind, BoundaryKind::kSlip);
  EXPECT_FALSE(s.side_given[kYlo]);
  const FineGrid grid = fine_grid(s.settings, periodic_directions(s.settings.fluid));
  EXPECT_EQ(grid.n(), (Int3{8, 4, 16}));
  EXPECT_TRUE(grid.axis[0].periodic());
  EXPECT_EQ(grid.axis[2].hi(), 0.016);
}

TEST(ScriptComplete, DomainSmallerThanAPeriodicBoxIsNotPeriodic) {
  Script s = fix(std::string(kFix) + " domain 0.002 0.006 0 0.004 0 0.016");
  complete(s, box(true));
  EXPECT_EQ(periodic_directions(s.settings.fluid), (std::array<bool, 3>{false, false, false}));
}

TEST(ScriptComplete, RefusesWhatTheBoxRulesOut) {
  const auto completed = [](const std::string& words, const std::string& more, bool periodic = false) {
    return sentence([&] {
      Script s = fix(words);
      if (!more.empty()) modify(s, more);
      complete(s, box(periodic));
    });
  };
  EXPECT_TRUE(has(completed(std::string(kFix) + " domain 0 0.008 0 0.005 0 0.016", ""), "0.005 in y"));
  EXPECT_TRUE(has(completed(kFix, "boundary xlo noslip", true), "f instead of p"));
  EXPECT_TRUE(has(completed(kFix, "boundary xlo periodic"), "p instead of f"));
  EXPECT_TRUE(has(completed("fine 8 1 16 density 1 viscosity 1 every 1", "boundary yhi noslip"), "gap friction"));
  EXPECT_TRUE(has(completed(kFix, "flow_rate z 1"), "flow_rate"));
  EXPECT_EQ(completed(kFix, "flow_rate x 1", true), "no exception");
  EXPECT_TRUE(has(completed(kFix, "flow_rate x 1 pressure_gradient -1 0 0", true), "one of the two"));
  EXPECT_TRUE(has(completed(kFix, "output every 15 file a.h5"), "multiple"));
  // a patch exactly as large as the face is on it, in spite of round-off
  EXPECT_EQ(completed(kFix, "boundary zlo patch all rect 0 0.0080000000000000002 0 0.004 inlet 0 0 1"), "no exception");
  // sides see their two directions in ascending order: y z on x sides
  EXPECT_EQ(completed(kFix, "boundary xlo patch slot rect 0 0.004 0 0.016 inlet 1 0 0"), "no exception");
  EXPECT_TRUE(has(completed(kFix, "boundary xlo patch slot rect 0 0.008 0 0.016 inlet 1 0 0"), "on the side's face"));
}

TEST(ScriptComplete, LengthsThatFitTheCells) {
  const auto completed = [](const std::string& more, const std::string& words = kFix) {
    return sentence([&] {
      Script s = fix(words);
      modify(s, more);
      complete(s, box());
    });
  };
  const std::string flat = "fine 1 1 1 density 1 viscosity 1 every 1";
  for (const std::string keyword : {"deposit cube", "read cube", "read kernel"}) {
    EXPECT_EQ(completed(keyword + " 0.003"), "no exception") << keyword;
    for (const std::string bad : {"1e-300", "1e-9", "0.0041", "1e300"})
      EXPECT_TRUE(has(completed(keyword + " " + bad), keyword + ": found")) << keyword << " " << bad;
    EXPECT_TRUE(has(completed(keyword + " 1e300", flat), keyword)) << keyword;
  }
}

TEST(ScriptComplete, MovingBoxesGetTheLineToWrite) {
  const int moving[3][2] = {{0, 0}, {1, 2}, {3, 1}};
  EXPECT_TRUE(has(sentence([&] { check_box_boundary(moving); }), "'boundary p f f'"));
  const int still[3][2] = {{0, 0}, {1, 1}, {1, 1}};
  EXPECT_EQ(sentence([&] { check_box_boundary(still); }), "no exception");
}

TEST(ScriptPatches, AreasAddUpAndBalanceIsAskedFor) {
  Script s = fix();
  modify(s, "boundary zlo inlet 0 0 0.5 boundary zlo patch jet rect 0.002 0.004 0 0.004 inlet 0 0 2");
  complete(s, box());
  const FluidSettings& f = s.settings.fluid;
  const FineGrid grid = fine_grid(s.settings, periodic_directions(f));
  EXPECT_NEAR(patch_sizes(f, kZlo, grid)[1].open, 0.002 * 0.004, 1e-18);  // 2 of 8 columns
  EXPECT_NEAR(patch_sizes(f, kZlo, grid)[0].open, 0.006 * 0.004, 1e-18);
  const std::string none = sentence([&] { f.check_flow(grid); });
  // 0.5 m/s over 0.006 x 0.004 m2 and 2 m/s over 0.002 x 0.004 m2
  EXPECT_TRUE(has(none, "no outlet") && has(none, "2.8e-05")) << none;

  FluidSettings balanced = f;
  balanced.side[kZhi][0].kind = BoundaryKind::kInlet;
  balanced.side[kZhi][0].velocity = {0, 0, 2.8e-5 / (0.008 * 0.004)};
  EXPECT_EQ(sentence([&] { balanced.check_flow(grid); }), "no exception");
  balanced.side[kZhi][0].kind = BoundaryKind::kPressure;
  EXPECT_EQ(sentence([&] { balanced.check_flow(grid); }), "no exception");
  balanced.side[kZlo][1].shape.value = {0.0021, 0.0022, 0, 0.004};
  EXPECT_TRUE(has(sentence([&] { balanced.check_flow(grid); }), "no fine face"));
}

}  // namespace
}  // namespace twogrid
