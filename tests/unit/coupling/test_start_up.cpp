// When start-up is over, and how sure means are. Series whose beginning and whose memory are known: a stationary process
// of first order (AR(1)) on an exponential beginning. Without it the means could hold start-up, or their claimed error be
// that of samples that know nothing of each other: several times too small, and nothing in a run shows it.
#include <gtest/gtest.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "coupling/output/averages.h"
#include "coupling/output/flow_numbers.h"
#include "coupling/output/start_up.h"
#include "tests/unit/coupling/output_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kDt = 1e-3;

/// Stationary, of unit variance and memory tau (s).
class Noise {
 public:
  Noise(unsigned seed, double tau) : random_(seed), keep_(std::exp(-kDt / tau)) { value_ = normal_(random_); }
  double next() { return value_ = keep_ * value_ + std::sqrt(1 - keep_ * keep_) * normal_(random_); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double keep_, value_;
};

/// Begins at the time when it is over; negative: never. pressure(t): what the pressure drop does.
template <class F>
double begun(StartUp& start_up, double end, F&& pressure) {
  for (long n = 1; n * kDt <= end; ++n) {
    FlowNumbers numbers{};
    numbers[kFlowPressureDrop] = pressure(n * kDt);
    numbers[kFlowFluidEnergy] = 0.5;  // 1 m/s
    start_up.add(n * kDt, kDt, numbers);
    if (start_up.over()) break;
  }
  return start_up.begun();
}

TEST(StartUp, LeavesAwayWhatIsNotStationary) {
  EXPECT_EQ(beginning_to_leave(std::vector<double>(64, 3.0), 0), 0);
  std::vector<double> step(64, 1.0);
  std::fill(step.begin(), step.begin() + 20, 9.0);
  EXPECT_EQ(beginning_to_leave(step, 0), 20);
  std::fill(step.begin(), step.begin() + 30, 9.0);
  EXPECT_EQ(beginning_to_leave(step, 0), 64);  // more than a third: not over
  std::vector<double> ramp(64);
  for (int i = 0; i < 64; ++i) ramp[i] = i;
  EXPECT_EQ(beginning_to_leave(ramp, 0), 64);
}

TEST(StartUp, ExponentialBeginningIsGone) {
  int late = 0, early = 0;
  double mean = 0;
  const int runs = 40;
  for (int r = 0; r < runs; ++r) {
    Noise noise(100 + r, 0.02);
    StartUp start_up(0.1);
    const double t = begun(start_up, 60, [&](double s) { return 10 * std::exp(-s / 0.3) + noise.next(); });
    ASSERT_GT(t, 0);
    // What is left of the beginning is then 1.4; in the means of a time as long, 0.7.
    early += t < 2 * 0.3;
    mean += t / runs, late += t > 6;
  }
  EXPECT_LT(mean, 4);  // three times as long as 10 exp(-t/0.3) takes to be lost in the noise, 0.8 s, and the last fifth
  EXPECT_LE(late, 2);
  EXPECT_LE(early, runs / 10);
}

// A bed that comes to rest, or a flow that becomes steady: each value is nearer to the end than those before it.
TEST(StartUp, WhatComesToRestIsOver) {
  StartUp start_up(0.1);
  const auto pressure = [](double t) { return 50 + 20 * std::exp(-t / 0.3); };
  double t = begun(start_up, 60, pressure);
  EXPECT_GT(t, 4 * 0.3);
  EXPECT_LT(t, 30 * 0.3);  // 0.001 of the beginning is left after 7, and that is a third
  for (int n = 0; n < 20000; ++n) {
    FlowNumbers numbers{};
    numbers[kFlowPressureDrop] = pressure(t += kDt), numbers[kFlowFluidEnergy] = 0.5;
    start_up.add(t, kDt, numbers);
  }
  EXPECT_EQ(start_up.state().restarts, 0);
}

TEST(StartUp, WhatNeverSettlesNeverBegins) {
  Noise noise(7, 0.02);
  StartUp start_up(0.1);
  EXPECT_LT(begun(start_up, 60, [&](double s) { return 20 * s + noise.next(); }), 0);
}

TEST(StartUp, FluidHasToPassTheDomain) {
  StartUp start_up(1.0);
  EXPECT_GE(begun(start_up, 60, [](double) { return 1.0; }), StartUp::kPasses * 1.0 - 1e-9);
}

TEST(StartUp, WhatNothingDrivesNeedNotPass) {
  StartUp start_up(1.0);
  start_up.want_passes(false);
  EXPECT_GT(begun(start_up, 60, [](double) { return 1.0; }), 0);
  EXPECT_LT(start_up.begun(), StartUp::kPasses * 1.0 / 2);
}

// Constant numbers whose sums are rounded, and a bed whose grains tremble less and less.
TEST(StartUp, RestIsRest) {
  StartUp start_up(0.1);
  double t = 0;
  while (!start_up.over() && t < 5) {
    FlowNumbers numbers{};
    numbers[kFlowPressureDrop] = 0.1, numbers[kFlowSolidsHeight] = 1.0 / 3, numbers[kFlowFluidEnergy] = 0.7;
    numbers[kFlowSolidsEnergy] = 1e-14 * std::exp(-t);
    start_up.add(t += kDt, kDt, numbers);
  }
  EXPECT_TRUE(start_up.over()) << start_up.why_not_over(t);
}

TEST(StartUp, SaysWhatItWaitsFor) {
  const auto has = [](const std::string& s, const char* part) { return s.find(part) != std::string::npos; };
  StartUp rising(0.1);
  begun(rising, 2, [](double s) { return 20 * s; });
  EXPECT_TRUE(has(rising.why_not_over(2), "the pressure drop still changes")) << rising.why_not_over(2);
  EXPECT_FALSE(has(rising.why_not_over(2), "passed"));
  StartUp passing(1.0);
  begun(passing, 2, [](double) { return 1.0; });
  EXPECT_TRUE(has(passing.why_not_over(2), "2 of 5 times, which takes some 3 s more")) << passing.why_not_over(2);
  StartUp early(0.1);
  begun(early, 0.0101, [](double) { return 1.0; });
  EXPECT_TRUE(has(early.why_not_over(0.01), "after 32 samples at couplings, and there are 10"));
}

TEST(StartUp, BeginsAnew) {
  StartUp start_up(0.1);
  EXPECT_FALSE(start_up.has_samples());
  const double first = begun(start_up, 60, [](double) { return 1.0; });
  ASSERT_GT(first, 0);
  start_up.begin_anew(first);
  EXPECT_FALSE(start_up.over());
  EXPECT_FALSE(start_up.has_samples());
  double t = first;
  for (int n = 0; n < 5000 && !start_up.over(); ++n) {
    FlowNumbers numbers{};
    numbers[kFlowPressureDrop] = 2, numbers[kFlowFluidEnergy] = 0.5;
    start_up.add(t += kDt, kDt, numbers);
  }
  EXPECT_NEAR(start_up.begun(), 2 * first, 0.01);
}

TEST(StartUp, DriftBeginsMeansAnewAndNoiseDoesNot) {
  int restarts = 0;
  for (int r = 0; r < 40; ++r) {
    Noise noise(300 + r, 0.05);
    StartUp start_up(0.1);
    const auto pressure = [&](double) { return 100 + noise.next(); };
    double t = begun(start_up, 60, pressure);
    ASSERT_GT(t, 0);
    for (int n = 0; n < 20000; ++n) {
      FlowNumbers numbers{};
      numbers[kFlowPressureDrop] = pressure(t += kDt), numbers[kFlowFluidEnergy] = 0.5;
      start_up.add(t, kDt, numbers);
    }
    restarts += start_up.state().restarts;
  }
  EXPECT_LE(restarts, 2);
  Noise noise(5, 0.05);
  StartUp start_up(0.1);
  double t = begun(start_up, 60, [&](double) { return 100 + noise.next(); });
  const double first = start_up.begun();
  for (int n = 0; n < 20000; ++n) {
    FlowNumbers numbers{};
    t += kDt;
    numbers[kFlowPressureDrop] = 100 + 0.5 * (t - first) + noise.next(), numbers[kFlowFluidEnergy] = 0.5;
    start_up.add(t, kDt, numbers);
  }
  EXPECT_GE(start_up.state().restarts, 1);
  EXPECT_GT(start_up.begun(), first);
}

TEST(StartUp, GoesOnFromACopyOfItsState) {
  Noise noise(9, 0.02);
  StartUp whole(0.1), second(0.1);
  for (long n = 1; n <= 8000; ++n) {
    FlowNumbers numbers{};
    numbers[kFlowPressureDrop] = 3 * std::exp(-n * kDt) + noise.next(), numbers[kFlowFluidEnergy] = 0.5;
    const std::string one = whole.add(n * kDt, kDt, numbers);
    if (n > 517) {
      EXPECT_EQ(second.add(n * kDt, kDt, numbers), one);
    } else if (n == 517) {
      second.state() = whole.state();
    }
  }
  EXPECT_TRUE(whole.over());
  EXPECT_EQ(whole.begun(), second.begun());
}

/// Void fraction 0.5 + 0.1 x(t), velocity in z 1 + 0.2 y(t), x and y noise of every block of cells by itself.
class NoisyFluid : public FormulaFluid {
 public:
  NoisyFluid(unsigned seed, double tau) : eps_(layout().cells(rank_of(MPI_COMM_WORLD)).grown(kHalo)) {
    for (int d = 0; d < 3; ++d) u_[d] = FormulaFluid::velocity()[d];
    for (int n = 0; n < 64; ++n) noise_.emplace_back(1000 * seed + n, tau), value_.push_back(0);
  }
  void step() {
    for (std::size_t n = 0; n < noise_.size(); ++n) value_[n] = noise_[n].next();
    const auto block = [](int i, int j, int k) { return ((i / 3) % 4 * 2 + (j / 2) % 2) * 4 + (k / 4) % 4; };
    for_each(eps_.box(),
             [&](int i, int j, int k) { eps_(i, j, k) = 0.5 + 0.1 * value_[block(wrapped(i), j & 3, k & 15)]; });
    for (int d = 0; d < 3; ++d)
      for_each(u_[d].box(), [&](int i, int j, int k) {
        // Of a block's cells: from the low face of the lowest to the high face of the highest.
        u_[d](i, j, k) = d == 2 ? 1 + 0.2 * value_[32 + block(wrapped(i), j & 3, k & 15)] : 0;
      });
    ++steps_;
  }
  double time() const override { return kDt * steps_; }
  const CellField<FineGrid>& void_fraction() const override { return eps_; }
  const FaceField<FineGrid>& velocity() const override { return u_; }

 private:
  std::vector<Noise> noise_;
  std::vector<double> value_;
  long steps_ = 0;
  CellField<FineGrid> eps_;
  FaceField<FineGrid> u_;
};

// Root mean square, over the cells and 12 runs, of what the means are off by: known, as the mean is.
TEST(MeansError, IsWhatTheMeansAreOffBy) {
  const double tau = 0.01;
  const ParticleGrid coarse(FormulaFluid().grid(), {3, 2, 4});
  double claimed = 0, off = 0, correlation = 0;
  const int runs = 12, steps = 4000;
  for (int r = 0; r < runs; ++r) {
    NoisyFluid fluid(1 + r, tau);
    Averages averages(MPI_COMM_WORLD, fluid.grid(), fluid.layout(), coarse);
    EXPECT_FALSE(averages.error().known());
    for (int n = 0; n < steps; ++n) fluid.step(), averages.add(kDt, fluid, Particles{});
    const MeansError e = averages.error();
    ASSERT_TRUE(e.trusted());
    claimed += e.eps * e.eps / runs, correlation += e.correlation_time / runs;
    double square = 0, volume = 0;
    std::size_t c = 0;
    for_each(averages.state().gas.own(), [&](int i, int j, int k) {
      const double mean = averages.state().gas.at(c++)[0] / averages.weight(),
                   v = coarse.shown_volume(i, j, k) * (1 - mean);
      square += v * (mean - 0.5) * (mean - 0.5), volume += v;
    });
    double sum[2] = {square, volume};
    MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    off += sum[0] / sum[1] / (0.5 * 0.5) / runs;
  }
  // 32 cells, 12 runs: the mean square is off by sqrt(2/384), 7 %, the scatter of 8 batches or more by 5 %.
  EXPECT_NEAR(std::sqrt(claimed / off), 1, 0.12);
  // The exact one: variance of the mean of 4 s is 2 tau/4 s of 0.1^2.
  EXPECT_NEAR(std::sqrt(claimed) / (0.2 * std::sqrt(2 * tau / (kDt * steps))), 1, 0.12);
  EXPECT_NEAR(correlation / tau, 1, 0.15);
}

TEST(MeansError, ShortBatchesAreNotTrusted) {
  const ParticleGrid coarse(FormulaFluid().grid(), {3, 2, 4});
  NoisyFluid fluid(3, 0.5);  // memory of 500 samples, batches of some 20
  Averages averages(MPI_COMM_WORLD, fluid.grid(), fluid.layout(), coarse);
  for (int n = 0; n < 300; ++n) fluid.step(), averages.add(kDt, fluid, Particles{});
  EXPECT_TRUE(averages.error().known());
  EXPECT_FALSE(averages.error().trusted());
  averages.begin_anew();
  EXPECT_FALSE(averages.error().known());
}

// Neighbouring batches are alike, so that their scatter divided by their number is no error; but a single one bounds it.
TEST(MeansError, SlowChangeIsBoundedByABatch) {
  const ParticleGrid coarse(FormulaFluid().grid(), {3, 2, 4});
  FormulaFluid fluid;
  Averages averages(MPI_COMM_WORLD, fluid.grid(), fluid.layout(), coarse);
  // eps_at() goes up by 0.5 x 0.17 x now, but for the cells in which it leaps.
  const int n = 320;
  for (int i = 0; i < n; ++i) fluid.set(1e-3 * i / n), averages.add(kDt, fluid, Particles{});
  const MeansError e = averages.error();
  EXPECT_FALSE(e.trusted());
  EXPECT_FALSE(e.steady());
  EXPECT_GT(e.lag, 0.5);
  EXPECT_GT(e.scatter, 1.5 * std::max(e.eps, e.flux));
  EXPECT_TRUE(e.within(2.1 * e.scatter, true));
  EXPECT_FALSE(e.within(1.9 * e.scatter, true));
  EXPECT_FALSE(e.within(2.1 * e.scatter, false));  // of too short a time it bounds nothing
}

TEST(MeansError, SteadyFlowIsSure) {
  const ParticleGrid coarse(FormulaFluid().grid(), {3, 2, 4});
  FormulaFluid fluid;
  Averages averages(MPI_COMM_WORLD, fluid.grid(), fluid.layout(), coarse);
  for (int i = 0; i < 1000; ++i) averages.add(kDt * (1 + 1e-3 * (i % 7)), fluid, Particles{});
  const MeansError e = averages.error();
  EXPECT_TRUE(e.steady());
  EXPECT_EQ(e.correlation_time, 0);
  EXPECT_TRUE(e.within(1e-6, true));
  // The gas has passed a length of 0.03 m so often.
  double square = 0, all = 0;
  for_each(averages.state().gas.own(), [&](int i, int j, int k) {
    all += coarse.shown_volume(i, j, k);
    for (int d = 0; d < 3; ++d) {
      double u = 0;
      const Box b = coarse.block(i, j, k);
      double volume = 0;
      for_each(b, [&](int x, int y, int z) {
        const auto& a = fluid.grid().axis;
        const double v = a[0].width(x) * a[1].width(y) * a[2].width(z);
        volume += v, u += v * fluid.centre_velocity(d, x, y, z, 0);
      });
      square += coarse.shown_volume(i, j, k) * u / volume * u / volume;
    }
  });
  double sum[2] = {square, all};
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_NEAR(e.passes, averages.weight() * std::sqrt(sum[0] / sum[1]) / 0.03, 1e-9 * e.passes);
}

TEST(FlowNumbers, AreThoseOfAllRanks) {
  FormulaFluid fluid;
  Cloud cloud(40);
  const FlowNumbers n = flow_numbers(MPI_COMM_WORLD, fluid, cloud.view(), {0.6, 0, 0.8}, 7.0);
  double volume = 0, z = 0, energy = 0;
  for (int id = 0; id < 40; ++id) {
    if (id % 5 == 4) continue;  // of another group
    const double v = std::pow(Cloud::radius_of(id), 3);
    volume += v, z += v * Cloud::position(id)[2];
    for (int d = 0; d < 3; ++d) energy += 0.5 * v * std::pow(Cloud::value(id, d), 2);
  }
  EXPECT_EQ(n[kFlowPressureDrop], 7.0);
  EXPECT_NEAR(n[kFlowSolidsHeight], 0.8 * z / volume, 1e-12);  // x is periodic
  EXPECT_NEAR(n[kFlowSolidsEnergy], energy / volume, 1e-9 * energy / volume);
  double square = 0, all = 0;
  for_each(Box{{0, 0, 0}, {12, 4, 16}}, [&](int i, int j, int k) {
    const auto& a = fluid.grid().axis;
    const double v = a[0].width(i) * a[1].width(j) * a[2].width(k);
    all += v;
    for (int d = 0; d < 3; ++d) square += 0.5 * v * std::pow(fluid.centre_velocity(d, i, j, k, 0), 2);
  });
  EXPECT_NEAR(n[kFlowFluidEnergy], square / all, 1e-12 * square / all);
}

}  // namespace
}  // namespace twogrid_test
