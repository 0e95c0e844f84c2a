// Rank 0 alone, for it alone writes these. The output file after a kill within the writes that show what is new, at each of them.
#include <gtest/gtest.h>
#include <mpi.h>

#include <cstdio>
#include <filesystem>

#include "cfd/parallel/ranks.h"
#include "coupling/output/growing_file.h"
#include "tests/unit/coupling/output_fakes.h"

namespace twogrid_test {
namespace {

class GrowingFileTest : public OutputTest {
 protected:
  void TearDown() override {
    HeldWrites::killed_after = -1;
    OutputTest::TearDown();
  }

  static std::string name(const char* group, int n) {
    char text[32];
    std::snprintf(text, sizeof text, "/%s/%06d", group, n);
    return text;
  }
  static double value(int n, int i) { return 1000.0 * n + i; }

  /// Frame n, of three values a rank in two groups, and a number that is written over.
  void add(const std::string& path, int n) {
    const std::size_t rank = rank_of(MPI_COMM_SELF), ranks = ranks_of(MPI_COMM_SELF);
    GrowingFile file(MPI_COMM_SELF, path, n == 0, 65536);
    Slab s;
    s.extent = {3 * ranks}, s.offset = {3 * rank}, s.count = {3};
    double values[3];
    for (int i = 0; i < 3; ++i) values[i] = value(n, int(3 * rank) + i);
    if (n == 0) file.group("/record");
    for (const char* g : {"fluid", "particles"}) {
      if (n == 0) file.group("/" + std::string(g), 4096);
      file.group(name(g, n));
      file.replicated(name(g, n) + "/time", {double(n)}, {}, "s");
      for (const char* d : {"u", "p", "eps", "position", "velocity", "drag"})
        file.slab(name(g, n) + "/" + d, s, values, "m/s");
    }
    file.attribute("/record", "last", double(n));
    if (n % 7 == 3) file.group("/record/leg_" + std::to_string(n));
    file.close();
  }

  /// Frames that the file has, all right; -1: it can't be opened, or something is wrong.
  static int frames(const std::string& path) {
    ReadBack file(path);
    if (!file.is_open()) return -1;
    int n = 0;
    for (; file.has(name("fluid", n)); ++n) {
      // Of a frame that is not finished one group may be there.
      for (const char* g : {"fluid", "particles"}) {
        if (!file.has(name(g, n))) continue;
        if (!file.has(name(g, n) + "/drag")) return -1;
        const std::vector<double> u = file.values(name(g, n) + "/u"), drag = file.values(name(g, n) + "/drag");
        for (int i = 0; i < int(u.size()); ++i)
          if (u[i] != value(n, i) || drag[i] != value(n, i)) return -1;
      }
    }
    return n;
  }
};

// Without it, a kill in the moment in which HDF5's tables are written over could leave a file that can't be opened, or has lost
// all its frames: the moment is so short that killing runs at random meets it once in thousands. The frames are so many that
// tables are split and moved.
TEST_F(GrowingFileTest, IsWholeAfterEachOfItsWrites) {
  const std::string path = directory_ + "/bed.h5", cut = directory_ + "/cut.h5";
  const int rank = rank_of(MPI_COMM_WORLD);
  if (rank != 0) return;
  int most = 0;
  for (int n = 0; n < 70; ++n) {
    const bool look = n == 1 || (n >= 7 && n < 18) || n == 40 || n == 69;
    for (int k = 0; look && k <= HeldWrites::writes + 1; ++k) {
      if (rank == 0) std::filesystem::copy_file(path, cut, std::filesystem::copy_options::overwrite_existing);
      HeldWrites::killed_after = k;
      add(cut, n);
      HeldWrites::killed_after = -1;
      if (rank == 0) {
        const int found = frames(cut);
        EXPECT_GE(found, n) << "frame " << n << ", killed after " << k << " of " << HeldWrites::writes << " writes";
        if (k >= HeldWrites::writes) {
          EXPECT_EQ(found, n + 1);
        }
      }
      most = std::max(most, HeldWrites::writes);
    }
    add(path, n);
  }
  EXPECT_GT(most, 3);
  if (rank == 0) {
    EXPECT_EQ(frames(path), 70);
  }
}

// Without it, what goes on in such a file could write over what it already names.
TEST_F(GrowingFileTest, GoesOnAfterAKill) {
  const std::string path = directory_ + "/bed.h5", cut = directory_ + "/cut.h5";
  const int rank = rank_of(MPI_COMM_WORLD);
  if (rank != 0) return;
  for (int n = 0; n < 9; ++n) add(path, n);
  for (int k = 0; k < 8; ++k) {
    if (rank == 0) std::filesystem::copy_file(path, cut, std::filesystem::copy_options::overwrite_existing);
    HeldWrites::killed_after = k;
    add(cut, 9);
    HeldWrites::killed_after = -1;
    {
      GrowingFile file(MPI_COMM_SELF, cut, false, 65536);  // as a run that goes on does
      file.remove(name("fluid", 9)), file.remove(name("particles", 9));
      file.close();
    }
    for (int n = 9; n < 14; ++n) add(cut, n);
    if (rank == 0) {
      EXPECT_EQ(frames(cut), 14) << "killed after " << k << " writes";
    }
  }
}

}  // namespace
}  // namespace twogrid_test
