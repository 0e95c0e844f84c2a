// The plan of a script: its model of ranks and its table.
// What would pass falsely without it: ranks that lie in the empty part of a box and take their share of the work all the
// same, a `processors` that is not kept, messages that cost nothing, and figures that stand in the wrong unit or row.
#include <gtest/gtest.h>

#include <cmath>

#include "liggghts_fixes/report/plan_model.h"
#include "liggghts_fixes/report/plan_table.h"
#include "liggghts_fixes/report/planned_bed.h"
#include "liggghts_fixes/script/consistency.h"

namespace twogrid {
namespace {

/// A bed in the lower third of a box twice as high as wide; measured on one rank.
PlannedRun bed(double hours) {
  PlannedRun r;
  r.line = "run 1000000";
  r.steps = 1000000, r.particles = 1e6, r.couplings = r.fluid_steps = 1e5, r.cells = 1e6;
  r.particle_seconds = 0.7 * 3600 * hours, r.fluid_seconds = 0.3 * 3600 * hours;
  r.reach = 1.5e-3;
  r.parts.length = {0.1, 0.1, 0.2};
  r.parts.hi = {1, 1, 1.0 / 3};
  return r;
}

TEST(PlanModel, BricksAsTheScriptWants) {
  PlannedParts p = bed(1).parts;
  EXPECT_EQ(planned_bricks(p, 2), (Int3{1, 1, 2}));  // the least surface
  EXPECT_EQ(planned_bricks(p, 16), (Int3{2, 2, 4}));
  p.wanted = {0, 0, 1};
  EXPECT_EQ(planned_bricks(p, 4), (Int3{2, 2, 1}));
  p.wanted = {3, 0, 0};
  EXPECT_TRUE(script_allows(p, 6));
  EXPECT_EQ(planned_bricks(p, 6)[0], 3);
  EXPECT_FALSE(script_allows(p, 4));
  p.wanted = {2, 1, 1};
  EXPECT_TRUE(script_allows(p, 2));
  EXPECT_FALSE(script_allows(p, 1));
  // Whoever has to choose other ones takes those in which the bed lies evenly, not those of the least surface.
  p.wanted = {1, 1, 1};
  EXPECT_EQ(planned_bricks(p, 2)[2], 1);
}

TEST(PlanModel, TheFullestRankDecides) {
  PlannedParts p = bed(1).parts;
  EXPECT_DOUBLE_EQ(fullest_share(p, 1), 1);
  EXPECT_DOUBLE_EQ(fullest_share(p, 2), 1);  // the upper one is empty
  p.wanted = {0, 0, 1};
  EXPECT_DOUBLE_EQ(fullest_share(p, 2), 0.5);
  p.wanted = {1, 1, 3};
  EXPECT_NEAR(fullest_share(p, 3), 1, 1e-12);
  p.wanted = {1, 1, 6};
  EXPECT_NEAR(fullest_share(p, 6), 0.5, 1e-12);
  p.follow = true;
  EXPECT_NEAR(fullest_share(p, 6), 1.1 / 6, 1e-12);
  // Bricks in which it lies askew.
  p = {};
  p.wanted = {4, 1, 1}, p.lo = {0.125, 0, 0}, p.hi = {0.625, 1, 1};
  EXPECT_NEAR(fullest_share(p, 4), 0.5, 1e-12);
}

TEST(PlanModel, TimeOnRanks) {
  PlannedRun r = bed(10);
  EXPECT_DOUBLE_EQ(seconds_on(r, 1), 36000);
  // The particles all lie on one of two: only the fluid gains, to half and its halo.
  const double uncut = seconds_on(r, 2);
  EXPECT_GT(uncut, 0.7 * 36000 + 0.15 * 36000);
  EXPECT_LT(uncut, 0.9 * 36000);
  r.parts.wanted = {0, 0, 1};
  const double two = seconds_on(r, 2), eight = seconds_on(r, 8);
  EXPECT_NEAR(two, 18000, 0.05 * 18000);
  EXPECT_NEAR(eight, 4500, 0.2 * 4500);
  EXPECT_GT(eight, 4500);
  // Twice the work of twice the steps, on any number.
  PlannedRun twice = r;
  twice.steps *= 2, twice.couplings *= 2, twice.fluid_steps *= 2, twice.particle_seconds *= 2, twice.fluid_seconds *= 2;
  for (int n : {1, 2, 7, 64, 1000})
    EXPECT_NEAR(seconds_on(twice, n), 2 * seconds_on(r, n), 1e-9 * seconds_on(r, n)) << n;
  // What is measured on two is what it would be on one, and back again.
  PlannedRun on_two = r;
  on_two.parts.bricks = planned_bricks(r.parts, 2);
  on_two.particle_seconds = 0.7 * two, on_two.fluid_seconds = 0.3 * two;
  EXPECT_DOUBLE_EQ(seconds_on(on_two, 2), two);
  EXPECT_NEAR(seconds_on(on_two, 1), 36000, 0.02 * 36000);
  // Many ranks for few particles: messages are all that is left.
  r.particle_seconds = r.fluid_seconds = 1;
  EXPECT_GT(seconds_on(r, 64), 1e6 * kPlannedMessage);
}

TEST(PlanModel, MemoryOnRanks) {
  PlannedParts p = bed(1).parts;
  p.wanted = {0, 0, 1};
  EXPECT_DOUBLE_EQ(bytes_on(p, 50e6, 250e6, 1), 250e6);
  EXPECT_DOUBLE_EQ(bytes_on(p, 50e6, 250e6, 4), 100e6);
  p.wanted = {1, 1, 0};
  EXPECT_DOUBLE_EQ(bytes_on(p, 50e6, 250e6, 2), 250e6);
}

TEST(PlannedBed, WhatTheGasCarries) {
  // 40 x 1 x 40 cells of 1 mm, floor and top open.
  Settings s;
  s.fine = {40, 1, 40}, s.ratio = {4, 1, 4};
  s.domain = {0, 0.04, 0, 0.001, 0, 0.04};
  const auto condition = [](BoundaryKind kind, double u) {
    BoundaryCondition c;
    c.kind = kind, c.velocity = {0, 0, u};
    return c;
  };
  const FineGrid grid = fine_grid(s, {false, false, false});
  SceneNumbers n;
  n.Umf = 0.5;
  SettledBed bed;
  bed.along = 2, bed.height = 0.01, bed.section = 0.04 * 0.001;
  const auto share = [&](double u) {
    s.fluid.side[4] = {condition(BoundaryKind::kInlet, u)};
    s.fluid.side[5] = {condition(BoundaryKind::kPressure, 0)};
    n.U_bed = u;
    return carried_share(s, grid, n, bed);
  };
  EXPECT_DOUBLE_EQ(share(0.4), 0);
  EXPECT_DOUBLE_EQ(share(0.5), 0);
  EXPECT_NEAR(share(0.625), 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(share(2), 1);
  // A jet over a tenth of the floor, and gas at rest beside it.
  s.fluid.side[4] = {condition(BoundaryKind::kInlet, 0.4), condition(BoundaryKind::kInlet, 8)};
  PatchShape& jet = s.fluid.side[4][1].shape;
  jet.kind = PatchShape::Kind::kRectangle, jet.value = {0.018, 0.022, 0, 0.001};
  s.fluid.side[4][1].name = "jet";
  EXPECT_NEAR(carried_share(s, grid, n, bed), 0.3, 1e-9);
  // No inlet, or no gravity: not known.
  n.U_bed = 0;
  EXPECT_LT(carried_share(s, grid, n, bed), 0);
  n.U_bed = 1, n.Umf = 0;
  EXPECT_LT(carried_share(s, grid, n, bed), 0);
}

TEST(PlannedBed, NeighbourLists) {
  // 0.65 m/s, half a skin of 0.5 mm: a list in 38.5 steps of 20 us.
  EXPECT_NEAR(planned_builds({0.5, 1.0}, 1e-3, 2e-5), 1 / 38.46, 1e-4);
  EXPECT_DOUBLE_EQ(planned_builds({0, 1.0}, 1e-3, 2e-5), 0);   // at rest
  EXPECT_DOUBLE_EQ(planned_builds({-1, 1.0}, 1e-3, 2e-5), 0);  // nothing blows
  EXPECT_DOUBLE_EQ(planned_builds({1, 1e6}, 1e-3, 2e-5), 1);   // no more than one a step
}

TEST(PlannedBed, Contacts) {
  EXPECT_DOUBLE_EQ(planned_contacts(0, 0.1, 0, 1), kSettledContacts);
  EXPECT_DOUBLE_EQ(planned_contacts(1, 0.1, 0, 1), kCarriedContacts);
  EXPECT_DOUBLE_EQ(planned_contacts(0, 2.9, 0, 1), 2.9);  // it lies there
  EXPECT_DOUBLE_EQ(planned_contacts(-1, 0.1, 0, 1), kSettledContacts);
  EXPECT_DOUBLE_EQ(planned_contacts(-1, 0.1, 5, 1), kSettledContacts / 3);  // all in the air
  EXPECT_NEAR(planned_contacts(-1, 0.1, 0.5, 1), kSettledContacts * 2 / 3, 1e-12);
  EXPECT_DOUBLE_EQ(planned_contacts(-1, 0.1, -3, 1), kSettledContacts);
}

TEST(PlanTable, TellsTimeMemoryFilesAndTheDearestRun) {
  Plan plan;
  plan.script = "in.bed";
  plan.runs = {bed(1), bed(9)};
  plan.runs[0].line = "run 5000", plan.runs[0].steps = 5000;
  plan.most_bytes = 2.5e9, plan.empty_bytes = 6e7;
  plan.files = {{"bed.h5", 3.2e9, "20 frames"}, {"mean.txt", 4.1e3, ""}};
  plan.remarks = {"a remark"};
  const std::string text = plan_text(plan);
  for (const char* said : {"the plan of in.bed", "10 h 00 min on 1 rank", "most of the time: run 2, run 1000000, 90 %",
                           "2.5 GB a rank", "3.2 GB  20 frames", "4.1 kB", "a remark", "a model of messages"})
    EXPECT_NE(text.find(said), std::string::npos) << said << "\n" << text;
  EXPECT_EQ(text.find("at most"), std::string::npos);
  plan.runs[1].at_most = true;
  EXPECT_NE(plan_text(plan).find("at most 10 h 00 min"), std::string::npos);
  plan.runs.clear();
  EXPECT_NE(plan_text(plan).find("no run"), std::string::npos);
}

TEST(PlanTable, Times) {
  EXPECT_EQ(planned_time(0.0123), "0.012 s");
  EXPECT_EQ(planned_time(59.6), "60 s");
  EXPECT_EQ(planned_time(200), "3 min 20 s");
  EXPECT_EQ(planned_time(36000), "10 h 00 min");
  EXPECT_EQ(planned_time(86400 * 100), "100 days");
}

}  // namespace
}  // namespace twogrid
