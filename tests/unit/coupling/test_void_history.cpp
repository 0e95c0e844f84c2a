// eps(t) of the coupling intervals against void fractions whose course in time is known: one that is a parabola is
// passed on exactly from the third interval on, whatever the intervals' lengths, and volume that is inserted or deleted
// changes eps without being a rate. Without this test a rate of the wrong sign or of the interval before would pass, as
// all other tests have void fractions that hardly bend in time.
#include <gtest/gtest.h>

#include "coupling/void_fraction/void_history.h"

using namespace twogrid;

namespace {

const Box kBox{{0, 0, 0}, {3, 2, 2}};

double parabola(std::size_t m, double t) {
  return 0.6 + 0.01 * double(m) + (0.1 - 0.03 * double(m)) * t + (0.05 * double(m % 3) - 0.04) * t * t;
}
double slope(std::size_t m, double t) {
  return 0.1 - 0.03 * double(m) + 2 * (0.05 * double(m % 3) - 0.04) * t;
}

}  // namespace

TEST(VoidHistory, AParabolaInTimeIsExact) {
  VoidHistoryState state;
  VoidHistory history(state, kBox, Interpolate::kSmooth);
  double t = 0;
  for (std::size_t m = 0; m < history.next().size(); ++m) history.next().data()[m] = parabola(m, t);
  history.start();
  int n = 0;
  for (double D : {0.1, 0.15, 0.06, 0.2, 0.13}) {
    for (std::size_t m = 0; m < history.next().size(); ++m) history.next().data()[m] = parabola(m, t + D);
    const VoidFractionInTime eps = history.begin(D, nullptr);
    for (std::size_t m = 0; m < history.next().size(); ++m) {
      for (double s : {0.0, 1.0}) EXPECT_DOUBLE_EQ(eps.at(std::ptrdiff_t(m), s, D), parabola(m, t + s * D));
      // The slope at the end is known after two intervals, that at the begin is the one of the interval before.
      if (n > 0) {
        EXPECT_NEAR(eps.end_slope(std::ptrdiff_t(m), D), slope(m, t + D), 1e-13) << "interval " << n;
      }
      for (double s : {0.2, 0.5, 0.9})
        if (n > 1) {
          EXPECT_NEAR(eps.at(std::ptrdiff_t(m), s, D), parabola(m, t + s * D), 1e-15) << "interval " << n;
        }
    }
    history.commit();
    t += D, ++n;
  }
}

// A course that goes on as a straight line stays one after a replacement: the jump is no rate.
TEST(VoidHistory, ReplacedVolumeIsNoRate) {
  VoidHistoryState state;
  VoidHistory history(state, kBox, Interpolate::kSmooth);
  CellField<FineGrid> replaced(kBox, -0.05);
  const double rate = 0.2;
  double t = 0, lower = 0;
  auto set = [&](double at) {
    for (std::size_t m = 0; m < history.next().size(); ++m) history.next().data()[m] = 0.6 - lower + rate * at;
  };
  set(t);
  history.start();
  for (int n = 0; n < 5; ++n) {
    const double D = 0.05 + 0.02 * n;
    if (n == 3) lower = 0.05;
    set(t + D);
    const VoidFractionInTime eps = history.begin(D, n == 3 ? &replaced : nullptr);
    for (double s : {0.0, 0.3, 0.7, 1.0})
      EXPECT_NEAR(eps.at(1, s, D), 0.6 - lower + rate * (t + s * D), 1e-15) << "interval " << n;
    history.commit();
    t += D;
  }
}
