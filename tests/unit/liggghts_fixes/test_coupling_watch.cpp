// The sentences about a coupling's report.
// What would pass falsely without it: an eps bound that moves most of the solids, or cannot be kept, in silence; a
// warning at every coupling, or one never again however bad it gets; a remedy that asks for what is there already.
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "liggghts_fixes/report/coupling_watch.h"

namespace twogrid {
namespace {

Report good() {
  Report r;
  r.solid_volume = 2e-6;
  r.travel = 0.1;
  r.solid_volume_error = r.momentum_error = 1e-15;
  r.eps_min = 0.4;
  return r;
}

bool has(const std::string& sentence, const std::string& part) {
  return sentence.find(part) != std::string::npos;
}

CouplingWatch watch(EpsBound bound, double eps_min) {
  Settings s;
  s.bound = bound, s.eps_min = eps_min;
  return CouplingWatch(s);
}
CouplingWatch move_03() {
  return watch(EpsBound::kMove, 0.3);
}

TEST(CouplingWatch, SilentWhereAllIsRight) {
  CouplingWatch w = move_03();
  EXPECT_TRUE(w.look(good(), 10, 1e-5).empty());
  Report none;  // no particle at all
  EXPECT_TRUE(w.look(none, 10, 1e-5).empty());
  Report edge = good();  // limits themselves are allowed
  edge.travel = 0.3;
  edge.volume_moved = 0.01 * edge.solid_volume;
  edge.solid_volume_error = edge.momentum_error = 1e-9;
  EXPECT_TRUE(w.look(edge, 10, 1e-5).empty());
}

TEST(CouplingWatch, OncePerDoubling) {
  CouplingWatch w = move_03();
  Report r = good();
  int said = 0;
  const double share[] = {0.005, 0.02, 0.02, 0.03, 0.039, 0.05, 0.01, 0.09, 0.2, 0.9};
  for (double s : share) r.volume_moved = s * r.solid_volume, said += int(w.look(r, 10, 1e-5).size());
  EXPECT_EQ(said, 4);  // 0.02, 0.05, 0.2, 0.9
}

TEST(CouplingWatch, EachFigureWithItsOwnSentence) {
  const auto one = [](void (*change)(Report&), EpsBound bound = EpsBound::kMove) {
    Report r = good();
    change(r);
    const auto said = watch(bound, 0.3).look(r, 10, 1e-5);
    EXPECT_EQ(said.size(), 1u);
    return said.empty() ? std::string() : said[0];
  };
  const std::string moved = one([](Report& r) { r.volume_moved = 1.8e-6; });
  EXPECT_TRUE(has(moved, "'eps bound move 0.3' moves 90 %") && has(moved, "ratio")) << moved;
  const std::string clipped = one(
      [](Report& r) {
        r.volume_moved = 1.8e-6;
        r.solid_volume_error = 0.9;
      },
      EpsBound::kClip);
  EXPECT_TRUE(has(clipped, "'eps bound clip 0.3' throws away 90 %")) << clipped;
  const std::string unplaced = one([](Report& r) {
    r.volume_unplaced = 1e-7;
    r.eps_min = 0.2;
  });
  EXPECT_TRUE(has(unplaced, "cannot be kept: 5 %") && has(unplaced, "down to 0.2")) << unplaced;
  EXPECT_TRUE(has(one([](Report& r) { r.solid_volume_error = 2e-9; }), "f_ID[6]"));
  EXPECT_TRUE(has(one([](Report& r) { r.momentum_error = 2e-9; }), "f_ID[7]"));
  const std::string behind = one([](Report& r) {
    r.behind_walls = 3;
    r.tag_behind = 7;
  });
  EXPECT_TRUE(has(behind, "3 particle(s), one of them of ID 7") && has(behind, "fix wall/gran")) << behind;
}

TEST(CouplingWatch, TravelNamesWhatCanBeLowered) {
  const auto remedy = [](double travel, int steps) {
    Report r = good();
    r.travel = travel;
    const auto said = move_03().look(r, steps, 1e-5);
    return said.empty() ? std::string() : said[0];
  };
  EXPECT_TRUE(has(remedy(0.6, 10), "lower every to 5")) << remedy(0.6, 10);
  EXPECT_TRUE(has(remedy(0.31, 2), "lower every to 1")) << remedy(0.31, 2);
  EXPECT_TRUE(has(remedy(6, 10), "lower every to 1 and timestep to 5e-06 s")) << remedy(6, 10);
  EXPECT_TRUE(has(remedy(0.6, 1), "lower timestep to 5e-06 s")) << remedy(0.6, 1);
  EXPECT_FALSE(has(remedy(0.6, 1), "every"));
  EXPECT_TRUE(has(remedy(0.6, 1), "ratio"));
  // The first deposit is no interval.
  EXPECT_EQ(remedy(0.6, 0), "");
}

TEST(CouplingWatch, ResponseTimeWithoutHolding) {
  Settings s;
  const auto said = [&](double drag_number, int steps) {
    Report r = good();
    r.max_drag_number = drag_number;
    const auto all = CouplingWatch(s).look(r, steps, 1e-5);
    return all.empty() ? std::string() : all[0];
  };
  EXPECT_EQ(said(50, 10), "");  // held where needed
  s.hold_flux = Choice::kOff;
  EXPECT_EQ(said(0.29, 10), "");
  EXPECT_EQ(said(50, 0), "");
  EXPECT_TRUE(has(said(0.6, 10), "lower every to 5")) << said(0.6, 10);
  EXPECT_TRUE(has(said(6, 10), "lower every to 1 and timestep to 5e-06 s")) << said(6, 10);
  s.one_way = true;
  EXPECT_EQ(said(50, 10), "");
}

TEST(CouplingWatch, CourantNumberWithDt) {
  Settings s;
  s.fluid.dt = 1e-4;
  Report r = good();
  const auto look = [&](double cfl, CouplingWatch w) {
    r.cfl = cfl;
    return w.look(r, 10, 1e-5);
  };
  EXPECT_TRUE(look(1, CouplingWatch(s)).empty());
  const auto said = look(8, CouplingWatch(s));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(has(said[0], "lower 'dt' to 5e-06 s")) << said[0];  // 0.4 of 1e-4 s/8
  EXPECT_THROW(look(1001, CouplingWatch(s)), std::runtime_error);
  EXPECT_TRUE(look(1001, move_03()).empty());  // without dt the step follows cfl
  s.fluid.convection = Convection::kNone;      // nothing to be unstable
  EXPECT_TRUE(look(1001, CouplingWatch(s)).empty());
}

// Without this test a run that goes on from a checkpoint could say again what was said, or lack a part of what it knows.
TEST(CouplingWatch, GoesOnFromItsEntriesAndNeedsEachOfThem) {
  Settings s;
  s.fluid.dt = 1e-4, s.eps_min = 0.3;
  const auto look = [](CouplingWatch& w, double much) {
    Report r = good();
    r.cfl = 3 * much, r.travel = 0.6 * much, r.volume_moved = 0.02 * much * r.solid_volume;
    r.volume_unplaced = 1e-8 * much * r.solid_volume;
    return w.look(r, 10, 1e-5);
  };
  const auto course = [&](CouplingWatch w) {
    std::vector<std::string> said;
    for (double much : {1.0, 1.5, 2.5, 1.0, 6.0})
      for (const std::string& sentence : look(w, much)) said.push_back(sentence);
    return said;
  };
  CouplingWatch whole(s);
  EXPECT_EQ(look(whole, 1.2).size(), 4u);
  const std::vector<std::string> right = course(whole);
  EXPECT_EQ(right.size(), 8u);  // each again at 2.5 and at 6
  int entries = 0;
  CouplingWatch::for_each_entry(whole, [&](const std::string& name, double&) {
    ++entries;
    for (const std::string& but : {std::string(), name}) {
      std::map<std::string, double> values;
      CouplingWatch::for_each_entry(whole, [&](const std::string& n, double& entry) { values[n] = entry; });
      CouplingWatch other(s);
      CouplingWatch::for_each_entry(other, [&](const std::string& n, double& entry) {
        if (n != but) entry = values.at(n);
      });
      EXPECT_EQ(course(other) == right, but.empty()) << "without " << but;
    }
  });
  EXPECT_EQ(entries, 4);
}

TEST(Losses, ToldAndLimited) {
  Schedule schedule;
  schedule.begin_run();
  EXPECT_EQ(losses(schedule, 100, 5, 10), "");
  EXPECT_TRUE(has(losses(schedule, 97, 5, 20), "3 particle(s) have vanished up to step 20"));
  EXPECT_EQ(losses(schedule, 95, 5, 30), "");  // told again when more than doubled; the limit itself is allowed
  EXPECT_THROW(losses(schedule, 94, 5, 40), std::runtime_error);
  EXPECT_TRUE(has(losses(schedule, 10, -1, 50), "90 particle(s)"));
  schedule.begin_run();  // between runs a script may delete what it likes
  EXPECT_EQ(losses(schedule, 1, 90, 60), "");
  EXPECT_THROW(losses(schedule, 0, 90, 70), std::runtime_error);
}

}  // namespace
}  // namespace twogrid
