// When a run couples and writes frames, and when it says that particles vanished. The state's list is whole and has no
// idle entry: a schedule that is given another's state goes on as that one does, and not so if one entry differs. Would
// pass falsely without: couplings whose phase a new run shifts, an interval that forgets the steps of another timestep,
// frames that are written twice or left out after one that came late, particles that commands delete between runs
// counted as lost, a warning at every coupling, and a checkpoint that lacks a part.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "coupling/control/schedule.h"

using namespace twogrid;

namespace {

using Steps = std::vector<long long>;

/// The couplings among steps [first, last].
Steps couplings(Schedule& s, long long first, long long last, int every, double dt = 1) {
  Steps found;
  for (long long n = first; n <= last; ++n) {
    s.count_step(n, dt, every);
    if (s.coupling()) found.push_back(n), s.end_interval();
    s.end_step();
  }
  return found;
}

/// All that follows of a schedule: couplings with interval, mean step, frame and what is told of lost particles.
std::vector<double> course(Schedule s, long long particles) {
  std::vector<double> out{s.interval()};
  for (long long n = 8; n <= 40; ++n) {
    s.count_step(n, 0.5, 5);
    if (!s.coupling()) continue;
    const double dt = s.mean_dt();
    s.end_interval();
    const bool frame = s.frame_due(n, 12);
    if (frame) s.frame_written(n, 12);
    for (double x : {double(n), dt, s.interval(), double(frame), double(s.count_particles(particles -= 2))})
      out.push_back(x);
    s.end_step();
  }
  return out;
}

}  // namespace

TEST(Schedule, CouplesAtMultiplesOfTheAbsoluteStep) {
  Schedule s(false);
  EXPECT_EQ(couplings(s, 3, 11, 4), (Steps{4, 8}));
  s.begin_run();
  EXPECT_EQ(s.steps(), 3);
  EXPECT_EQ(couplings(s, 12, 21, 4), (Steps{12, 16, 20}));
}

TEST(Schedule, CouplesByTheStepsSinceTheLastWhereTheyChange) {
  Schedule s(true);
  EXPECT_EQ(couplings(s, 3, 11, 4), (Steps{6, 10}));
  EXPECT_EQ(couplings(s, 12, 16, 3), (Steps{13, 16}));
  EXPECT_EQ(couplings(s, 17, 18, 5), (Steps{}));
  EXPECT_EQ(couplings(s, 19, 19, 2), (Steps{19}));  // a shorter interval, already over
}

TEST(Schedule, AnIntervalIsTheTimeOfItsStepsWhateverTheirLength) {
  Schedule s(false);
  EXPECT_EQ(s.interval(), 0);
  couplings(s, 1, 4, 4, 0.25);
  EXPECT_EQ(s.interval(), 1);
  couplings(s, 5, 6, 4, 0.25);
  s.count_step(7, 0.5, 4), s.count_step(8, 0.5, 4);
  EXPECT_TRUE(s.coupling());
  EXPECT_EQ(s.steps(), 4);
  EXPECT_EQ(s.mean_dt(), 0.375);
  EXPECT_EQ(s.interval(), 1);  // still the last
  s.end_interval();
  EXPECT_EQ(s.interval(), 1.5);
  EXPECT_EQ(s.steps(), 0);
  EXPECT_TRUE(s.coupling());
  s.end_step();
  EXPECT_FALSE(s.coupling());
}

TEST(Schedule, AFrameIsDueAtTheFirstCouplingFromItsStepOn) {
  Schedule s;
  Steps frames;
  for (long long n : {0, 4, 8, 12, 27, 28, 32, 36, 44}) {
    EXPECT_FALSE(s.frame_due(n, 0));
    if (s.frame_due(n, 10)) frames.push_back(n), s.frame_written(n, 10);
  }
  EXPECT_EQ(frames, (Steps{0, 12, 27, 32, 44}));
}

TEST(Schedule, TellsOfVanishedParticlesWhenTheyHaveMoreThanDoubled) {
  Schedule s;
  Steps told;
  for (long long now : {100, 100, 99, 98, 97, 110, 107, 100, 100}) told.push_back(s.count_particles(now));
  EXPECT_EQ(told, (Steps{0, 0, 1, 0, 3, 0, 0, 13, 0}));
  s.begin_run();  // commands deleted 50
  EXPECT_EQ(s.count_particles(50), 0);
  EXPECT_EQ(s.count_particles(36), 27);
}

TEST(Schedule, GoesOnInAnotherFromACopyOfItsState) {
  for (bool every_changes : {false, true}) {
    Schedule one(every_changes);
    couplings(one, 1, 7, 5, 0.25);
    one.frame_written(5, 12), one.count_particles(101), one.count_particles(100);
    const std::vector<double> right = course(one, 100);

    std::map<std::string, bool> matters;
    ScheduleState::for_each_entry(one.state(), [&](const std::string& name, auto&) { matters[name] = false; });
    EXPECT_EQ(matters.size(), 5u);
    for (auto& [other, yes] : matters) {
      Schedule copy(every_changes);
      copy.state() = one.state();
      EXPECT_EQ(course(copy, 100), right);
      ScheduleState::for_each_entry(copy.state(), [&](const std::string& name, auto& entry) {
        if (name == other) entry += 5;
      });
      yes = course(copy, 100) != right;
    }
    for (const auto& [name, yes] : matters) EXPECT_TRUE(yes) << name << " makes no difference";
  }
}
