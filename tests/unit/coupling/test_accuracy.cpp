// Steps in time for a wanted accuracy. Would pass falsely without: a control that never shortens, never lengthens, or
// runs away where the error is noise that a shorter step makes larger.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

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
