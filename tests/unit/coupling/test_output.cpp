// The files of a run, read back by one rank through HDF5's serial side and compared with values computed from the
// formulas below, not from the arrays that were written.
#include <gtest/gtest.h>
#include <mpi.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <memory>
#include <utility>

#include "cfd/parallel/ranks.h"
#include "coupling/output/averages.h"
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
  output.begin(0, 0);
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

// Without it, a start where a file is could destroy results, or, where asked to, leave frames of the older run behind, which
// read like new ones; and a run that is refused before it begins could have destroyed them already.
TEST_F(OutputTest, AFileThatIsThereIsReplacedOnlyWhenAskedTo) {
  const auto frames = [&](int count) {
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    output.begin(0, 0);
    Cloud cloud(10);
    for (int n = 0; n < count; ++n) output.frame(n, n, cloud.view());
    output.begin(0, 0);  // a second run of the same fix: nothing new
  };
  frames(2);
  MPI_Barrier(MPI_COMM_WORLD);
  const std::string before = read_text(settings_.output.file);
  const std::string s = sentence([&] { frames(1); });
  EXPECT_NE(s.find("there already"), std::string::npos) << s;
  EXPECT_NE(s.find("2 frames"), std::string::npos) << s;
  EXPECT_NE(s.find("overwrite yes"), std::string::npos) << s;
  settings_.output.overwrite = true;
  { Output output(MPI_COMM_WORLD, settings_, fluid_, {}); }  // never begun
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_TRUE(read_text(settings_.output.file) == before);
  MPI_Barrier(MPI_COMM_WORLD);
  frames(1);
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

// Without it, two runs in one folder could write into each other's file; or a lock that a killed run has left could keep all
// others out.
TEST_F(OutputTest, AFileIsWrittenByOneRunAtATime) {
  settings_.output.overwrite = true;
  auto first = std::make_unique<Output>(MPI_COMM_WORLD, settings_, fluid_, Record{});
  first->begin(0, 0);
  Output second(MPI_COMM_WORLD, settings_, fluid_, {});
  const std::string s = sentence([&] { second.begin(0, 0); });
  EXPECT_NE(s.find("another run (process "), std::string::npos) << s;
  first.reset();
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(access((settings_.output.file + ".lock").c_str(), F_OK), -1);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) std::ofstream(settings_.output.file + ".lock") << "process 1 on a node";  // killed
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(sentence([&] { second.begin(0, 0); }), "");
}

// Without it, a run that goes on from a checkpoint could begin another file, repeat frames, or go on in a file of another
// run; and the means could begin anew, or count particles of a checkpoint twice.
TEST_F(OutputTest, ARunGoesOnInItsFile) {
  settings_.output.average_from = 0;
  const auto sample = [&](Output& output, int n) {
    fluid_.set(n);
    Cloud cloud(20 + n);
    // On another rank than the cell's.
    for (auto& x : cloud.x) x[0] = std::fmod(x[0] + 0.0007 * n, 0.012);
    output.average(0.01, cloud.view(), 0);
    if (n % 3 == 0) output.frame(n, n, cloud.view());
  };
  OutputState state;
  AveragesState means;
  Settings whole = settings_;
  whole.output.file = directory_ + "/whole.h5";
  {
    Output one(MPI_COMM_WORLD, settings_, fluid_, {}), other(MPI_COMM_WORLD, whole, fluid_, {});
    one.begin(0, 0), other.begin(0, 0);
    for (int n = 0; n < 27; ++n) sample(one, n), sample(other, n);
    one.averages()->gather(), other.averages()->gather();
    state = one.state(), means = one.averages()->state();
    for (int n = 27; n < 34; ++n) sample(one, n);  // killed then
    for (int n = 27; n < 44; ++n) sample(other, n);
    other.finish();
  }
  std::vector<std::string> said;
  {
    Output again(MPI_COMM_WORLD, settings_, fluid_, {});
    again.state() = state, again.averages()->state() = means;
    said = again.begin(26, 26);
    for (int n = 27; n < 44; ++n) sample(again, n);
    again.finish();
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("after 9 frames"), std::string::npos) << said[0];
    EXPECT_NE(said[0].find("3 later ones"), std::string::npos) << said[0];
    ReadBack one(settings_.output.file), other(whole.output.file);
    ASSERT_TRUE(one.is_open() && other.is_open());
    for (int n = 0; n < 15; ++n) {
      char frame[32];
      std::snprintf(frame, sizeof frame, "/fluid/%06d", n);
      ASSERT_TRUE(one.has(frame)) << n;
      EXPECT_EQ(one.values(std::string(frame) + "/step")[0], 3.0 * n);
      EXPECT_EQ(one.values(std::string(frame) + "/p"), other.values(std::string(frame) + "/p"));
    }
    EXPECT_FALSE(one.has("/fluid/000015"));
    for (const char* d : {"fine/u", "fine/p_variance", "particle_grid/eps", "particle_grid/solids_flux",
                          "particle_grid/batch/solids_flux", "particle_grid/batch/eps", "particle_grid/batch/weight"})
      EXPECT_EQ(one.values(std::string("/average/") + d), other.values(std::string("/average/") + d)) << d;
    EXPECT_TRUE(one.has("/record/leg_2"));
    check_xdmf(directory_ + "/bed.xdmf", one);
    std::size_t shown = 0;
    const std::string xdmf = read_text(directory_ + "/bed.xdmf"), series = read_text(directory_ + "/whole.xdmf");
    for (std::size_t at = xdmf.find("<Time"); at != std::string::npos; at = xdmf.find("<Time", at + 1)) ++shown;
    EXPECT_EQ(shown, 15u);
    EXPECT_EQ(xdmf, std::regex_replace(series, std::regex("whole\\.h5"), "bed.h5"));
  }
  MPI_Barrier(MPI_COMM_WORLD);
  // With any entry of the state as a new process has it.
  OutputState::for_each_entry(state, [&](const std::string& name, double& entry) {
    const double right = std::exchange(entry, 0.0);
    Output foreign(MPI_COMM_WORLD, settings_, fluid_, {});
    foreign.state() = state;
    const std::string s = sentence([&] { foreign.begin(26, 26); });
    EXPECT_NE(s.find("of another run"), std::string::npos) << name << ": " << s;
    entry = right;
  });
}

// Without it, a checkpoint could be on the disk, and the frames before it not, and no one be told.
TEST_F(OutputTest, IsBroughtToTheDiskOrTellsOfIt) {
  Output output(MPI_COMM_WORLD, settings_, fluid_, {});
  EXPECT_EQ(output.sync(), "") << "nothing is there yet";
  output.begin(0, 0);
  EXPECT_EQ(output.sync(), "");
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    EXPECT_EQ(std::remove(settings_.output.file.c_str()), 0);
  }
  const std::string s = output.sync();
  EXPECT_NE(s.find("No such file"), std::string::npos) << s;
  MPI_Barrier(MPI_COMM_WORLD);
}

// Without it, `legs many` could destroy an older leg, or ParaView could show a moment twice; and a file that a machine has
// left damaged could stop the run for good.
TEST_F(OutputTest, LegsOfARunAreOneSeries) {
  settings_.output.many_legs = true;
  OutputState state;
  const auto leg = [&](int from, int to) {  // steps
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    output.state() = state;
    const auto said = output.begin(from, from);
    state = output.state();
    Cloud cloud(5);
    for (int n = from + 1; n <= to; ++n) output.frame(n, n, cloud.view());
    return said;
  };
  const auto series = [&] {
    std::string s;
    const std::string xdmf = read_text(directory_ + "/bed.xdmf");
    const std::regex frame("<Time Value=\"([0-9]+)\"/>[^:]*>([a-z0-9.]+):");
    for (std::sregex_iterator m(xdmf.begin(), xdmf.end(), frame), end; m != end; ++m)
      s += (*m)[1].str() + " " + (*m)[2].str() + "; ";
    return s;
  };
  leg(0, 4);
  leg(3, 6);
  leg(2, 4);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_EQ(series(), "1 bed.h5; 2 bed.h5; 3 bed.3.h5; 4 bed.3.h5; ");
  settings_.output.many_legs = false;
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    EXPECT_EQ(truncate((directory_ + "/bed.3.h5").c_str(), 3000), 0);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const auto said = leg(4, 5);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("bed.3.h5 is damaged"), std::string::npos) << said[0];
  }
  EXPECT_EQ(series(), "1 bed.h5; 2 bed.h5; 3 bed.h5; 4 bed.2.h5; 5 bed.4.h5; ");
}

// Without it, a wrong word in a script could be taken in silence, or end one rank only and leave the others waiting.
TEST_F(OutputTest, RefusesWhatCannotBeWrittenInOneSentenceOnAllRanks) {
  auto refusal = [&](const std::string& file, const std::vector<std::string>& fields) {
    settings_.output.file = file;
    settings_.output.fields = fields;
    return sentence([&] { Output(MPI_COMM_WORLD, settings_, fluid_, {}).begin(0, 0); });
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
  output.begin(0, 0);
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
