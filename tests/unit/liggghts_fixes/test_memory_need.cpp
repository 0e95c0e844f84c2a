// The memory that is estimated before anything is allocated.
// What would pass falsely without it: an estimate that is off by a factor, or whole numbers that overflow, so that a
// grid too large is begun.
#include <gtest/gtest.h>

#include <stdexcept>

#include "liggghts_fixes/report/memory_need.h"

namespace twogrid {
namespace {

Settings box_of(int n) {
  Settings s;
  s.fine = {n, n, n};
  s.ratio = {2, 2, 2};
  return s;
}

TEST(MemoryNeed, BytesACell) {
  // Measured 307 to 400 bytes a fine cell, and 650 a particle cell, an eighth of it here.
  const double a_cell = bytes_needed(box_of(200), {1, 1, 1}, 0) / 8e6;
  EXPECT_GT(a_cell, 307);
  EXPECT_LT(a_cell, 400 + 650.0 / 8);
  Settings s = box_of(200);
  s.ratio = {1, 1, 1};
  EXPECT_NEAR(bytes_needed(s, {1, 1, 1}, 0) / 8e6 - a_cell, 650 * 7 / 8.0, 1e-6);
  // What a scene asks for beside it costs more.
  s = box_of(200);
  s.formulation = Formulation::kA;
  EXPECT_GT(bytes_needed(s, {1, 1, 1}, 0) / 8e6, a_cell + 48);
  // Measured with a cylinder across the box, the growth of the resident set: 294 and 332 bytes a cell.
  const auto of_bodies = [](int n) {
    return (bytes_needed(box_of(n), {1, 1, 1}, 1) - bytes_needed(box_of(n), {1, 1, 1}, 0)) / n / n / n;
  };
  EXPECT_NEAR(of_bodies(100), 294, 30);
  EXPECT_NEAR(of_bodies(64), 332, 33);
  // Thin bricks have more halo.
  EXPECT_GT(bytes_needed(box_of(200), {1, 1, 50}, 0), 1.5 * bytes_needed(box_of(200), {1, 1, 1}, 0));
}

TEST(MemoryNeed, RefusesWhatDoesNotFit) {
  const auto sentence = [](const Settings& s, double most) -> std::string {
    try {
      return check_memory(MPI_COMM_WORLD, s, {1, 1, 1}, most, 0);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(has(sentence(box_of(10), 2147483647.0), "1000 fine cells need about")) << sentence(box_of(10), 1e9);
  Settings huge = box_of(2000000000);
  const std::string many = sentence(huge, 2147483647.0), memory = sentence(huge, 1e30);
  EXPECT_TRUE(has(many, "8e+27 cells") && has(many, "2147483647")) << many;
  EXPECT_TRUE(has(memory, "8e+27 fine cells") && has(memory, "are free")) << memory;
  EXPECT_TRUE(has(sentence(box_of(60000), 1e30), "2.16e+14")) << sentence(box_of(60000), 1e30);
}

TEST(MemoryNeed, FreeIsAMachine) {
  EXPECT_GT(bytes_free(), 1e6);
  EXPECT_LT(bytes_free(), 1e15);
  EXPECT_EQ(bytes_text(230e6), "230 MB");
  EXPECT_EQ(bytes_text(9.12e12), "9.1 TB");
  EXPECT_EQ(bytes_text(999.9e6), "1 GB");
}

}  // namespace
}  // namespace twogrid
