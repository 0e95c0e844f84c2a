#include "coupling/output/record.h"

#include <ctime>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/growing_file.h"

namespace twogrid {

namespace {

const char* const kXyz[3] = {"x", "y", "z"};

std::string mpi_version() {
  char s[MPI_MAX_LIBRARY_VERSION_STRING];
  int n;
  MPI_Get_library_version(s, &n);
  return std::string(s, n);
}

void write_nodes(GrowingFile& file, const std::string& group, const Grid& grid) {
  file.group(group);
  std::vector<int> periodic;
  for (int d = 0; d < 3; ++d) {
    const auto nodes = grid.axis[d].nodes();
    file.replicated(group + "/" + kXyz[d], nodes, {nodes.size()}, "m");
    periodic.push_back(grid.axis[d].periodic());
  }
  file.attribute(group, "periodic", periodic);
}

}  // namespace

std::string now() {
  const std::time_t t = std::time(nullptr);
  char s[32];
  std::strftime(s, sizeof s, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&t));
  return s;
}

double bytes_of_record(const Record& record, const Fluid& fluid) {
  const Int3& n = fluid.grid().n();
  return 262144 + 16 * (n[0] + n[1] + n[2] + 3.0) + double(record.input_text.size() + record.command_line.size());
}

void write_record(GrowingFile& file, MPI_Comm comm, const Settings& s, const Fluid& fluid, const ParticleGrid& coarse,
                  const Record& record, const std::string& id) {
  const Int3& n = fluid.grid().n();
  const std::string at = "/record";
  file.group(at);
  auto say = [&](const std::string& name, const std::string& value) { file.attribute(at, name, value); };
  auto say_all = [&](const std::string& group, const std::vector<std::pair<std::string, std::string>>& pairs) {
    for (const auto& [name, value] : pairs) file.attribute(group, name, value);
  };
  say("program", "twogrid");
  say("run", id);
  say("version", TWOGRID_VERSION);
  say("commit", TWOGRID_COMMIT);
  say("compiler", __VERSION__);
  say("HDF5", Hdf5File::library_version());
  say("MPI", mpi_version());
  say_all(at, record.versions);
  say("date", now());
  say("command_line", record.command_line);
  file.text(at + "/input_text", record.input_text);

  const int ranks = ranks_of(comm);
  file.attribute(at, "ranks", std::vector<int>{ranks});
  const auto& cuts = fluid.layout().cuts();
  file.attribute(at, "bricks",
                 std::vector<int>{int(cuts[0].size()) - 1, int(cuts[1].size()) - 1, int(cuts[2].size()) - 1});
  file.attribute(at, "fine", std::vector<int>(n.begin(), n.end()));
  file.attribute(at, "ratio", std::vector<int>(s.ratio.begin(), s.ratio.end()));
  file.attribute(at, "every", std::vector<int>{s.every});
  file.attribute(at, "density", fluid.density());
  file.attribute(at, "viscosity", fluid.viscosity());
  file.attribute(at, "drag", s.drag);
  file.attribute(at, "formulation", s.formulation == Formulation::kA ? "A" : "B");
  file.group(at + "/settings");
  say_all(at + "/settings", record.settings);

  write_nodes(file, "/grid", fluid.grid());
  write_nodes(file, "/particle_grid", coarse);
  file.attribute("/particle_grid", "ratio", std::vector<int>(s.ratio.begin(), s.ratio.end()));
}

void write_leg(GrowingFile& file, MPI_Comm comm, const Record& record, int leg, long step) {
  const std::string at = "/record/leg_" + std::to_string(leg);
  file.group(at);
  file.attribute(at, "date", now());
  file.attribute(at, "commit", TWOGRID_COMMIT);
  file.attribute(at, "ranks", std::vector<int>{ranks_of(comm)});
  file.attribute(at, "command_line", record.command_line);
  file.attribute(at, "checkpoint_step", double(step));
}

}  // namespace twogrid
