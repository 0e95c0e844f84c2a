// Largest values and sums over ranks in one message.
//
// Without these tests would pass: a largest value that is summed or the other way round, a NaN of one rank that gets
// lost between others' numbers, ranks that end with different values, a last place that is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "cfd/parallel/ranks.h"
#include "cfd/parallel/reduction.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

TEST(ReductionOverRanks, LargestAndSums) {
  const int rank = rank_of(MPI_COMM_WORLD), ranks = ranks_of(MPI_COMM_WORLD);
  double a = rank, b = -rank - 1.5, c = 1 + rank, d = 0.5;
  Reduction::over_ranks(MPI_COMM_WORLD, {&a, &b}, {&c, &d});
  EXPECT_EQ(a, ranks - 1);
  EXPECT_EQ(b, -1.5);
  EXPECT_EQ(c, 0.5 * ranks * (ranks + 1));
  EXPECT_EQ(d, 0.5 * ranks);
}

TEST(ReductionOverRanks, NotANumberStays) {
  const int rank = rank_of(MPI_COMM_WORLD), ranks = ranks_of(MPI_COMM_WORLD);
  for (int bad = 0; bad < ranks; ++bad) {
    double a = rank == bad ? NAN : 1e300, b = rank;
    Reduction::over_ranks(MPI_COMM_WORLD, {&a, &b}, {});
    EXPECT_TRUE(std::isnan(a)) << "rank " << bad;
    EXPECT_EQ(b, ranks - 1);
  }
}

TEST(ReductionOverRanks, AllPlaces) {
  const int rank = rank_of(MPI_COMM_WORLD), ranks = ranks_of(MPI_COMM_WORLD);
  static_assert(Reduction::kLargest == 8 && Reduction::kSums == 12, "the lists below name them all");
  double a[8], b[12];
  for (int i = 0; i < 8; ++i) a[i] = 10 * i + rank;
  for (int i = 0; i < 12; ++i) b[i] = i + 1;
  Reduction::over_ranks(MPI_COMM_WORLD, {&a[0], &a[1], &a[2], &a[3], &a[4], &a[5], &a[6], &a[7]},
                        {&b[0], &b[1], &b[2], &b[3], &b[4], &b[5], &b[6], &b[7], &b[8], &b[9], &b[10], &b[11]});
  for (int i = 0; i < 8; ++i) EXPECT_EQ(a[i], 10 * i + ranks - 1) << i;
  for (int i = 0; i < 12; ++i) EXPECT_EQ(b[i], (i + 1) * ranks) << i;
}

TEST(ReductionOverRanks, TooManyAreRefused) {
  double x[Reduction::kLargest + 1] = {};
  EXPECT_THROW(
      Reduction::over_ranks(MPI_COMM_WORLD, {&x[0], &x[1], &x[2], &x[3], &x[4], &x[5], &x[6], &x[7], &x[8]}, {}),
      std::logic_error);
}

}  // namespace
}  // namespace twogrid_test
