// Parts of rows that loops work on where bodies close their ends.
// What would pass falsely without it: an open cell that no loop reaches, a part that sticks out of the box.
#include <gtest/gtest.h>

#include "cfd/measures/row_measures.h"

namespace twogrid {
namespace {

TEST(OpenRows, HoldAllThatIsOpenAndStayInTheBox) {
  const Box box{{-2, 3, 5}, {17, 9, 8}};
  for (int group : {OpenRows::kDoubles, OpenRows::kFloats})
    for (int salt = 0; salt < 50; ++salt) {
      const auto open = [&](int i, int j, int k) {
        const int begin = (salt * 7 + j * 5 + k * 3) % 19 - 2, length = (salt + j * k) % 12;
        return i >= begin && i < begin + length && (i + salt) % 5 != 0;
      };
      const OpenRows rows(box, group, open);
      Array3<double> visited(box, 0.0);
      for_each_row(box, &rows, visited, [&](const Int3& x, std::ptrdiff_t m, int n) {
        EXPECT_GT(n, 0);
        EXPECT_EQ(visited.index(x[0], x[1], x[2]), m);
        for (int i = 0; i < n; ++i) {
          ASSERT_TRUE(box.contains(x[0] + i, x[1], x[2]));
          visited(x[0] + i, x[1], x[2]) += 1;
        }
      });
      for (int k = box.lo[2]; k < box.hi[2]; ++k)
        for (int j = box.lo[1]; j < box.hi[1]; ++j) {
          int first = box.hi[0], last = box.lo[0] - 1, worked_on = 0;
          for (int i = box.lo[0]; i < box.hi[0]; ++i) {
            if (open(i, j, k)) {
              first = std::min(first, i), last = i;
              EXPECT_EQ(visited(i, j, k), 1);
            }
            worked_on += int(visited(i, j, k));
          }
          const int needed = std::max(0, last + 1 - first);
          EXPECT_EQ(worked_on, std::min(box.size(0), (needed + group - 1) / group * group));
        }
    }
}

TEST(OpenRows, WithoutATableRowsAreWhole) {
  const Box box{{1, 0, 0}, {6, 2, 3}};
  const Array3<double> like(box);
  int rows = 0;
  for_each_row(box, nullptr, like, [&](const Int3& x, std::ptrdiff_t, int n) {
    EXPECT_EQ(x[0], 1);
    EXPECT_EQ(n, 5);
    ++rows;
  });
  EXPECT_EQ(rows, 6);
}

}  // namespace
}  // namespace twogrid
