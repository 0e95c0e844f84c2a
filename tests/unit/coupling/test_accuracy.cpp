// Steps in time for a wanted accuracy. Would pass falsely without: a control that never shortens, never lengthens, or
// runs away where the error is noise that a shorter step makes larger.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "coupling/control/accuracy.h"

using namespace twogrid;

namespace {

double settled(StepControl c, const std::function<double(double)>& error, int checks) {
  for (int i = 0; i < checks; ++i) c.note(error(c.step()));
  return c.step();
}

}  // namespace

TEST(Accuracy, FirstOrderErrorIsHeldAtWhatIsWanted) {
  const auto error = [](double every) { return 0.002 * every; };
  for (double begin : {1.0, 7.0, 100.0}) {
    const double step = settled(StepControl(0.03, 1, begin, true, 1, 100), error, 60);
    EXPECT_GT(error(step), 0.03 * 0.8);
    EXPECT_LE(error(step), 0.03 * 1.25);
  }
}

TEST(Accuracy, SecondOrderErrorIsHeldAtWhatIsWanted) {
  const auto error = [](double cfl) { return 0.5 * cfl * cfl; };
  const double step = settled(StepControl(0.01, 2, 0.4, true, 0.05, 0.8), error, 60);
  EXPECT_GT(error(step), 0.01 * 0.6);
  EXPECT_LE(error(step), 0.01 * 1.6);
}

TEST(Accuracy, NoiseThatGrowsAsTheStepShrinksLeavesTheStepWhereItWas) {
  const auto noise = [](double every) { return 0.3 / every; };
  StepControl c(0.01, 1, 8, true, 1, 100);
  for (int i = 0; i < 6; ++i) c.note(noise(c.step()));
  EXPECT_EQ(c.step(), 8);
  EXPECT_TRUE(c.noisy());
  EXPECT_GE(c.shortest(), 4);
  for (int i = 0; i < 300; ++i) c.note(noise(c.step()));
  EXPECT_GE(c.shortest(), 4);
}

TEST(Accuracy, StepsStayWithinTheirLimitsAndGivenOnesStay) {
  EXPECT_EQ(settled(
                StepControl(0.1, 1, 3, true, 1, 100), [](double) { return 1e-9; }, 99),
            100);
  EXPECT_EQ(settled(
                StepControl(1e-4, 1, 3, true, 1, 100), [](double every) { return 0.1 * every; }, 99),
            1);
  EXPECT_EQ(settled(
                StepControl(1e-4, 1, 3, false, 1, 100), [](double every) { return 0.1 * every; }, 99),
            3);
}

TEST(Accuracy, TheIntervalStaysBelowTheParticlesResponseTime) {
  Accuracy a(0.1, 10, true, 0.4, true);
  for (int i = 0; i < 50; ++i) a.adjust(1e-6, 1e-6, 0.02 * a.every());
  EXPECT_LE(0.02 * a.every(), 0.86);
  EXPECT_GE(0.02 * a.every(), 0.7);
}

TEST(Accuracy, ChecksComeEarlyAndThenAtMostOnceInAHundredCouplings) {
  Accuracy a(0.01, 5, true, 0.4, true);
  int checks = 0;
  for (int coupling = 0; coupling < 10000; ++coupling) {
    const bool due = a.due();
    a.count_coupling();
    if (!due) continue;
    ++checks;
    a.adjust(1e-4, 0.01, 0.1);
  }
  EXPECT_GE(checks, 100);
  EXPECT_LE(checks, 106);
  EXPECT_FALSE(Accuracy().due());
}

namespace {

constexpr double kWanted = 0.01;

/// Checks and couplings; errors of the steps, with a noise of the method in some of them. What comes of it.
std::vector<double> go_on(Accuracy& a, int kind, int from, int couplings) {
  std::vector<double> out;
  for (int n = from; n < from + couplings; ++n) {
    const bool check = a.due();
    a.count_coupling();
    if (check) {
      const double size = std::pow(10, 1.5 * std::sin(0.002 * kind * n + kind));
      const double noise = n % 700 > 350 && kind % 2 ? 0.02 : 0;
      a.adjust(0.01 * size * a.cfl() * a.cfl() + 0.1 * noise, 0.002 * size * a.every() + noise, 0.001 * a.every());
    }
    out.insert(out.end(), {double(check), double(a.every()), a.cfl()});
  }
  for (const StepControl* c : {&a.fluid(), &a.coupling()})
    out.insert(out.end(), {c->mean_error(), c->shortest(), c->longest(), double(c->noisy())});
  out.push_back(double(a.checks()));
  return out;
}

void hand_over(Accuracy& from, Accuracy& to, const std::string& but) {
  std::map<std::string, double> values;
  Accuracy::for_each_entry(from, [&](const std::string& name, const auto& entry) { values[name] = double(entry); });
  Accuracy::for_each_entry(to, [&](const std::string& name, auto& entry) {
    if (name != but) entry = std::decay_t<decltype(entry)>(values.at(name));
  });
}

}  // namespace

// Without this test a run could go on from a checkpoint with a part of what it has learned, and choose other steps.
TEST(Accuracy, GoesOnFromItsEntriesAndNeedsEachOfThem) {
  const auto fresh = [] { return Accuracy(kWanted, 5, true, 0.4, true); };
  std::map<std::string, bool> matters;
  for (int run = 0; run < 300; ++run) {
    const int kind = 1 + run / 50, stop = 3 + 57 * (run % 50);
    Accuracy whole = fresh();
    go_on(whole, kind, 0, stop);
    Accuracy other = fresh(), going = whole;
    hand_over(whole, other, "");
    const std::vector<double> right = go_on(going, kind, stop, 1500);
    EXPECT_EQ(go_on(other, kind, stop, 1500), right) << stop;
    Accuracy::for_each_entry(whole, [&](const std::string& name, const auto&) {
      Accuracy less = fresh();
      hand_over(whole, less, name);
      matters[name] = matters[name] || go_on(less, kind, stop, 1500) != right;
    });
  }
  EXPECT_EQ(matters.size(), 23u);
  for (const auto& [name, yes] : matters) EXPECT_TRUE(yes) << name << " makes no difference";
}
