// Borders between ranks where as many particles lie on either side.
//
// Without these tests would pass: borders that overtake each other, that jump over a neighbour (LIGGGHTS loses what has
// to go further than to the next rank), parts narrower than the ghosts' layer, or no end of moving.
#include <gtest/gtest.h>

#include <cmath>

#include "liggghts_fixes/liggghts/even_borders.h"

namespace twogrid_test {
namespace {

using twogrid::even_borders;

std::vector<double> equal(int parts) {
  std::vector<double> b;
  for (int i = 0; i <= parts; ++i) b.push_back(double(i) / parts);
  return b;
}

/// All particles evenly below `height`.
std::vector<long long> bed(double height) {
  std::vector<long long> count(1024);
  for (int i = 0; i < 1024; ++i) count[i] = i < height * 1024 ? 100 : 0;
  return count;
}

TEST(EvenBorders, ArriveAfterSomeSteps) {
  for (int parts : {2, 3, 4, 8}) {
    std::vector<double> b = equal(parts);
    for (int step = 0; step < 2 * parts; ++step) {
      const std::vector<double> next = even_borders(bed(0.25), b, 0.01);
      for (int i = 1; i < parts; ++i) {
        EXPECT_GE(next[i], b[i - 1]);
        EXPECT_LE(next[i], b[i + 1]);
        EXPECT_GE(next[i] - next[i - 1], 0.01 - 1e-15);
      }
      EXPECT_EQ(next.front(), 0);
      EXPECT_EQ(next.back(), 1);
      b = next;
    }
    for (int i = 0; i < parts; ++i) EXPECT_NEAR(b[i], 0.25 * i / parts, 1e-3);
    EXPECT_EQ(even_borders(bed(0.25), b, 0.01), b);
  }
}

TEST(EvenBorders, NotNarrowerThanGhosts) {
  std::vector<double> b = equal(4);
  for (int step = 0; step < 10; ++step) b = even_borders(bed(0.02), b, 0.1);
  for (int i = 1; i <= 4; ++i) EXPECT_GE(b[i] - b[i - 1], 0.1 - 1e-15);
}

TEST(EvenBorders, NoParticles) {
  const std::vector<double> b = even_borders(std::vector<long long>(1024), equal(3), 0.05);
  for (double x : b) EXPECT_TRUE(std::isfinite(x) && x >= 0 && x <= 1);
}

}  // namespace
}  // namespace twogrid_test
