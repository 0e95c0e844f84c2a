// The file status.json.
// What would pass falsely without it: a file that no reader of JSON takes, because of a quote in a path or a number that
// is not one; a status that covers up an error by "finished"; a run that ends because its status can't be written; a
// reader that finds half a file.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "liggghts_fixes/report/status.h"

namespace twogrid {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A folder of its own, gone at the end.
struct Folder {
  Folder() {
    char name[] = "/tmp/twogrid_status_XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() {
    chmod(path.c_str(), 0700);
    const std::string clean = "rm -rf " + path;
    if (std::system(clean.c_str()) != 0) ADD_FAILURE() << clean;
  }
  std::string read(const std::string& name) const {
    std::ifstream in(path + "/" + name);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  std::string path;
};

TEST(Status, Names) {
  EXPECT_EQ(status_name("log.liggghts"), "status.json");
  EXPECT_EQ(status_name("out/a.b/log.liggghts"), "out/a.b/status.json");
  EXPECT_EQ(status_name("/scratch/second.log"), "/scratch/second.status.json");
  EXPECT_EQ(status_name("log.second"), "second.status.json");
  EXPECT_EQ(status_name(".log"), ".log.status.json");
  EXPECT_EQ(status_name("none"), "");
}

TEST(Status, NumbersAndTextsThatJsonLacks) {
  RunStatus s;
  s.fluid = true;
  s.report.cfl = std::numeric_limits<double>::quiet_NaN();
  s.report.pressure_drop = std::numeric_limits<double>::infinity();
  s.report.fluid_time = 0.1;
  s.state = "error";
  s.error = "a \"quote\", a \\ and\na line of 5 \u00b5m, and a byte \xff that is none";
  const std::string text = status_json(s);
  EXPECT_TRUE(has(text, "\"courant_number\": null")) << text;
  EXPECT_TRUE(has(text, "\"pressure_drop\": null")) << text;
  EXPECT_TRUE(has(text, "\"time\": 0.1,")) << text;
  EXPECT_TRUE(has(text, "\"error\": \"a \\\"quote\\\", a \\\\ and\\u000aa line of 5 \u00b5m, and a byte \\u00ff that"))
      << text;
  EXPECT_TRUE(has(text, "\"checkpoint\": null")) << text;
  EXPECT_FALSE(has(text, ",\n}")) << text;
}

TEST(Status, FollowsARun) {
  const Folder folder;
  Status s;
  s.open(folder.path + "/status.json", "twogrid", 0, 4);
  EXPECT_TRUE(has(folder.read("status.json"), "\"running\": false"));
  s.begin_run(100, 100, 300);
  EXPECT_TRUE(has(folder.read("status.json"), "\"steps_to_go\": 200, \"seconds_to_go\": null"));
  Report r;
  r.fluid_time = 0.5;
  ScheduleState schedule;
  schedule.particles = 40, schedule.lost = 2;
  s.couple(150, r, schedule, 10);
  EXPECT_TRUE(has(folder.read("status.json"), "\"steps_done\": 0")) << "written before its time";
  s.checkpoint("bed.checkpoint", 150);
  EXPECT_TRUE(has(folder.read("status.json"), "{\"path\": \"bed.checkpoint\", \"step\": 150"));
  s.end_at(400);  // not before its own end
  s.end_run(300);
  const std::string text = folder.read("status.json");
  EXPECT_TRUE(has(text, "\"particles\": 50,\n  \"particles_lost\": 2")) << text;
  EXPECT_TRUE(has(text, "\"steps_done\": 200, \"steps_to_go\": 0")) << text;
  EXPECT_NEAR(s.now().steps_per_second * s.now().wall_per_simulated, 200 / 0.5, 1e-6);
  s.begin_run(300, 300, 900);
  s.end_at(700);
  s.end_run(700);
  EXPECT_TRUE(has(folder.read("status.json"), "\"last_step\": 700, \"steps_done\": 400, \"steps_to_go\": 0"));
  s.fail("it broke");
  s.finish();
  EXPECT_TRUE(has(folder.read("status.json"), "\"state\": \"error\",\n  \"error\": \"it broke\""));
  EXPECT_NE(access((folder.path + "/status.json.part").c_str(), F_OK), 0);
}

TEST(Status, OnlyOneRankWritesButForItsOwnError) {
  const Folder folder;
  Status s;
  s.open(folder.path + "/status.json", "twogrid", 3, 4);
  s.begin_run(0, 0, 10);
  s.end_run(10);
  EXPECT_EQ(folder.read("status.json"), "");
  s.fail_alone("this rank's");
  EXPECT_TRUE(has(folder.read("status.json"), "this rank's"));
}

/// A folder that is not there, a full device: nothing happens.
TEST(Status, NeverInTheWay) {
  const Folder folder;
  Status gone, full, none;
  gone.open(folder.path + "/gone/status.json", "twogrid", 0, 1);
  gone.begin_run(0, 0, 10);
  gone.end_run(10);
  full.open(folder.path + "/status.json", "twogrid", 0, 1);
  const std::string before = folder.read("status.json"), part = folder.path + "/status.json.part";
  ASSERT_EQ(symlink("/dev/full", part.c_str()), 0);
  full.finish();
  EXPECT_EQ(folder.read("status.json"), before) << "the one before stays where the new one can't be written";
  none.open("", "twogrid", 0, 1);
  none.finish();
}

}  // namespace
}  // namespace twogrid
