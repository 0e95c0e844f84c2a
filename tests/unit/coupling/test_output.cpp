// The files of a run, read back by one rank through HDF5's serial side and compared with values computed from the
// formulas below, not from the arrays that were written.
#include <gtest/gtest.h>
#include <mpi.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>

#include "cfd/parallel/ranks.h"
#include "tests/unit/coupling/output_fakes.h"

namespace twogrid_test {
namespace {

// Without it, a wrong offset between a rank's halo and its part of the file, a swapped dimension, or a lost brick would
// pass: pictures would still look plausible. The file is read while the run goes on, with no closing call, as after a
// kill.
TEST_F(OutputTest, FramesHoldTheValuesOfEveryCellFaceAndParticle) {
  settings_.output.fields = {"u", "p", "eps", "faces"};
  Record record{"fix gas all twogrid\nrun 0\n",
                "twogrid -in in.bed",
                {{"LIGGGHTS", "3.8.0"}},
                {{"eps bound", "move 0.3"}, {"boundary", "zlo slip; zhi slip"}}};
  Output output(MPI_COMM_WORLD, settings_, fluid_, record);
  const int particles[3] = {40, 0, 23};  // changes from frame to frame; none at all in the second
  for (int n = 0; n < 3; ++n) {
    fluid_.set(n);
    Cloud cloud(particles[n]);
    output.frame(0.5 * n, 100 * n, cloud.view());
    if (n == 1) output.finish();  // between two runs of one process
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.text("/record/input_text"), record.input_text);
    EXPECT_EQ(file.text_attribute("/record", "command_line"), record.command_line);
    EXPECT_EQ(file.text_attribute("/record", "LIGGGHTS"), "3.8.0");
    for (const auto& [keyword, value] : record.settings)
      EXPECT_EQ(file.text_attribute("/record/settings", keyword.c_str()), value);
    EXPECT_EQ(file.int_attribute("/record", "ranks"), ranks_of(MPI_COMM_WORLD));
    const char* xyz[3] = {"x", "y", "z"};
    for (int d = 0; d < 3; ++d) {
      const auto fine = fluid_.grid().axis[d].nodes(), coarse = file.values(std::string("/particle_grid/") + xyz[d]);
      EXPECT_EQ(file.values(std::string("/grid/") + xyz[d]), fine);
      ASSERT_EQ(int(coarse.size()), fluid_.grid().axis[d].n() / settings_.ratio[d] + 1);
      for (std::size_t i = 0; i < coarse.size(); ++i) EXPECT_EQ(coarse[i], fine[i * settings_.ratio[d]]);
    }
    for (int n = 0; n < 3; ++n) {
      const std::string at = "/fluid/00000" + std::to_string(n), faces = at + "/faces/";
      EXPECT_EQ(file.values(at + "/time"), std::vector<double>{0.5 * n});
      EXPECT_EQ(file.values(at + "/step"), std::vector<double>{100.0 * n});
      ASSERT_EQ(file.extent(at + "/p"), (std::vector<hsize_t>{16, 4, 12}));
      ASSERT_EQ(file.extent(at + "/u"), (std::vector<hsize_t>{16, 4, 12, 3}));
      const auto p = file.values(at + "/p"), eps = file.values(at + "/eps"), u = file.values(at + "/u"),
                 deps = file.values(faces + "deps_dt");
      int wrong = 0;
      std::size_t c = 0;
      for_each(Box{{0, 0, 0}, {12, 4, 16}}, [&](int i, int j, int k) {
        wrong += p[c] != FormulaFluid::p_at(i, j, k, n);
        wrong += eps[c] != FormulaFluid::eps_at(i, j, k, n);
        wrong += deps[c] != FormulaFluid::dilation_at(i, j, k);
        for (int d = 0; d < 3; ++d) wrong += u[3 * c + d] != fluid_.centre_velocity(d, i, j, k, n);
        ++c;
      });
      for (int d = 0; d < 3; ++d) {
        Int3 size{12, 4, 16};
        if (d > 0) ++size[d];  // x is periodic: its last face is its first
        ASSERT_EQ(file.extent(faces + "u" + xyz[d]),
                  (std::vector<hsize_t>{hsize_t(size[2]), hsize_t(size[1]), hsize_t(size[0])}));
        const auto face = file.values(faces + "u" + xyz[d]), flux = file.values(faces + "flux_" + xyz[d]);
        c = 0;
        for_each(Box{{0, 0, 0}, size}, [&](int i, int j, int k) {
          wrong += face[c] != FormulaFluid::u_at(d, i, j, k, n);
          wrong += flux[c] != FormulaFluid::flux_at(d, i, j, k);
          ++c;
        });
      }
      EXPECT_EQ(wrong, 0) << "frame " << n;

      const std::string points = "/particles/00000" + std::to_string(n);
      int expected = 0;
      for (int id = 0; id < particles[n]; ++id) expected += id % 5 != 4;  // others are not of the group
      ASSERT_EQ(file.extent(points + "/position"), (std::vector<hsize_t>{hsize_t(expected), 3}));
      if (!expected) continue;
      const auto id = file.values(points + "/id"), x = file.values(points + "/position"),
                 v = file.values(points + "/velocity"), f = file.values(points + "/force"),
                 radius = file.values(points + "/radius"), drag = file.values(points + "/drag"),
                 pressure = file.values(points + "/pressure_force"), seen = file.values(points + "/eps");
      std::vector<int> met(particles[n], 0);
      for (int row = 0; row < expected; ++row) {
        const int i = int(id[row]);
        ++met[i];
        for (int d = 0; d < 3; ++d) {
          EXPECT_EQ(x[3 * row + d], Cloud::position(i)[d]);
          EXPECT_EQ(v[3 * row + d], Cloud::value(i, d));
          EXPECT_EQ(f[3 * row + d], Cloud::value(i, 3 + d));
          EXPECT_EQ(drag[3 * row + d], Cloud::value(i, 10 + kDragForce + d));
          EXPECT_EQ(pressure[3 * row + d], Cloud::value(i, 10 + kPressureForce + d));
        }
        EXPECT_EQ(radius[row], Cloud::radius_of(i));
        EXPECT_EQ(seen[row], Cloud::value(i, 10 + kVoidFraction));
      }
      for (int i = 0; i < particles[n]; ++i) EXPECT_EQ(met[i], i % 5 != 4) << "particle " << i;
    }
    // 3 frames of grid (3 + 3 datasets) and 2 of particles (8 datasets).
    EXPECT_EQ(check_xdmf(directory_ + "/bed.xdmf", file), 3 * 6 + 2 * 8);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Without it, a second start under the same name could leave frames of the older run behind, which read like new ones.
TEST_F(OutputTest, AStartWritesOverAnOlderFile) {
  for (int run = 0; run < 2; ++run) {
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    Cloud cloud(10);
    for (int n = 0; n < 2 - run; ++n) output.frame(n, n, cloud.view());
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_TRUE(file.has("/fluid/000000"));
    EXPECT_FALSE(file.has("/fluid/000001"));
    EXPECT_FALSE(file.has("/fluid/000000/faces"));  // not asked for
    EXPECT_FALSE(file.has("/average"));
    check_xdmf(directory_ + "/bed.xdmf", file);
  }
}

// Without it, a wrong word in a script could be taken in silence, or end one rank only and leave the others waiting.
TEST_F(OutputTest, RefusesWhatCannotBeWrittenInOneSentenceOnAllRanks) {
  auto refusal = [&](const std::string& file, const std::vector<std::string>& fields) {
    settings_.output.file = file;
    settings_.output.fields = fields;
    return sentence([&] { Output output(MPI_COMM_WORLD, settings_, fluid_, {}); });
  };
  const std::string good = directory_ + "/bed.h5";
  EXPECT_NE(refusal(good, {"u", "vorticity"}).find("'vorticity'"), std::string::npos);
  EXPECT_NE(refusal("", {}).find("output file"), std::string::npos);
  EXPECT_NE(refusal(directory_ + "/none/bed.h5", {}).find("No such file or directory"), std::string::npos);
  EXPECT_NE(refusal("/proc/bed.h5", {}).find("cannot be written"), std::string::npos);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ASSERT_EQ(symlink("/dev/full", good.c_str()), 0);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_NE(refusal(good, {}).find("not a regular file"), std::string::npos);
}

// Without it, a disk that fills up during the run would hang it (one rank throws, the others wait), or leave a file
// that can't be read any more. The limit on the size of files stands for the full disk.
TEST_F(OutputTest, AFrameThatFindsNoRoomThrowsOnAllRanksAndLeavesTheFileReadable) {
  Output output(MPI_COMM_WORLD, settings_, fluid_, {});
  Cloud cloud(20);
  output.frame(0, 0, cloud.view());
  struct rlimit old;
  getrlimit(RLIMIT_FSIZE, &old);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct stat before;
  ASSERT_EQ(stat(settings_.output.file.c_str(), &before), 0);
  MPI_Barrier(MPI_COMM_WORLD);
  struct rlimit tight = old;
  tight.rlim_cur = before.st_size + 10000;
  setrlimit(RLIMIT_FSIZE, &tight);
  const std::string s = sentence([&] { output.frame(1, 1, cloud.view()); });
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_NE(s.find("cannot be written"), std::string::npos) << s;
  EXPECT_NE(s.find("output every"), std::string::npos) << s;
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.values("/fluid/000000/p").back(), FormulaFluid::p_at(11, 3, 15, 0));
    EXPECT_FALSE(file.has("/fluid/000001"));
  }
  MPI_Barrier(MPI_COMM_WORLD);
  // With room again it goes on.
  output.frame(2, 2, cloud.view());
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.values("/fluid/000001/time"), std::vector<double>{2});
    check_xdmf(directory_ + "/bed.xdmf", file);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

}  // namespace
}  // namespace twogrid_test
