#include "coupling/checkpoint/checkpoint.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "cfd/fluid_solver.h"
#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/state_file.h"
#include "coupling/control/schedule.h"
#include "coupling/coupling.h"
#include "coupling/coupling_state.h"

namespace twogrid {

namespace {

constexpr char kKeyword[] = "checkpoint";
constexpr int kVersion = 1;

ParticleGrid nodes_of(const CheckpointParts& c) {
  return ParticleGrid(c.fluid.grid(), c.settings.ratio);
}

/// What must be the same, in words.
std::string scene(const CheckpointParts& c) {
  std::ostringstream s;
  s.precision(17);
  const FineGrid& grid = c.fluid.grid();
  s << "fine";
  for (int n : grid.n()) s << " " << n;
  s << ", ratio";
  for (int r : c.settings.ratio) s << " " << r;
  s << ", domain";
  for (const Axis& a : grid.axis) s << " " << a.lo() << " " << a.lo() + a.length() << (a.periodic() ? " periodic" : "");
  s << ", formulation " << (c.settings.formulation == Formulation::kA ? "A" : "B");
  // These decide which levels and fields there are.
  s << ", convection " << (c.settings.fluid.convection == Convection::kCentral ? "central" : "not central");
  s << ", interpolate " << (c.settings.interpolate == Interpolate::kSmooth ? "smooth" : "linear");
  s << ", one-way " << (c.settings.one_way ? "yes" : "no");
  s << ", density " << c.fluid.density();
  for (const ModelField& f : c.fluid.model_fields()) s << ", " << f.name;
  return s.str();
}

template <class F>
void for_each_state(const CheckpointParts& c, F&& f) {
  f("/fluid", c.fluid.state_to_restore());
  f("/coupling", c.coupling.state());
  f("/schedule", c.schedule);
}

double bytes_of(const CheckpointParts& c) {
  double values = 0;
  for_each_state(c, [&](const char*, auto& state) {
    std::decay_t<decltype(state)>::for_each_entry(state, [&](const char*, const auto& entry) {
      if constexpr (!std::is_arithmetic_v<std::decay_t<decltype(entry)>>) values += double(entry.size());
    });
  });
  MPI_Allreduce(MPI_IN_PLACE, &values, 1, MPI_DOUBLE, MPI_SUM, c.comm);
  return 8 * values + 262144;
}

/// On the disk, under its name. Empty: done; else why not.
std::string put_in_place(const std::string& from, const std::string& to) {
  const int f = open(from.c_str(), O_RDONLY);
  const bool synced = f >= 0 && fsync(f) == 0;
  std::string why = synced ? "" : std::strerror(errno);
  if (f >= 0) close(f);
  if (!synced) return why;
  if (std::rename(from.c_str(), to.c_str()) != 0) return std::strerror(errno);
  const std::size_t slash = to.find_last_of('/');
  const int folder = open(slash == std::string::npos ? "." : to.substr(0, slash + 1).c_str(), O_RDONLY | O_DIRECTORY);
  if (folder >= 0) fsync(folder), close(folder);
  return "";
}

}  // namespace

void write_plain_checkpoint(const std::string& path, const CheckpointParts& c, long long step, long long particles) {
  const Layout nodes = node_layout(c.fluid.layout(), nodes_of(c));
  Hdf5File file(c.comm, path, Hdf5File::Mode::kCreate, bytes_of(c), kKeyword);
  file.group("/record");
  file.attribute("/record", "version", std::vector<int>{kVersion});
  file.attribute("/record", "scene", scene(c));
  file.replicated("/record/step", {double(step)}, {1});
  file.replicated("/record/particles", {double(particles)}, {1});
  file.replicated("/record/every", {double(c.settings.every)}, {1});
  StateFile states(c.comm, c.fluid.layout(), nodes, file);
  for_each_state(c, [&](const char* group, const auto& state) { states.write(group, state); });
  file.close();
}

void write_checkpoint(const std::string& path, const CheckpointParts& c, long long step, long long particles) {
  const std::string part = path + ".part";
  try {
    write_plain_checkpoint(part, c, step, particles);
  } catch (...) {
    if (rank_of(c.comm) == 0) std::remove(part.c_str());
    throw;
  }
  char why[256] = {};
  if (rank_of(c.comm) == 0) std::snprintf(why, sizeof why, "%s", put_in_place(part, path).c_str());
  MPI_Bcast(why, sizeof why, MPI_CHAR, 0, c.comm);
  if (why[0])
    throw std::runtime_error("the checkpoint '" + path + "' could not be put in place (" + why +
                             "); give another path (fix_modify ID checkpoint write)");
}

void read_checkpoint(const std::string& path, const CheckpointParts& c, long long step, long long particles) {
  const Layout nodes = node_layout(c.fluid.layout(), nodes_of(c));
  Hdf5File file(c.comm, path, Hdf5File::Mode::kRead, 0, kKeyword);
  const bool ours = file.has("/record") && file.has("/record/step") && file.has("/record/particles");
  if (!ours)
    throw std::invalid_argument("checkpoint read: found " + path +
                                ", an HDF5 file that is no checkpoint; wanted one "
                                "that 'fix_modify ID checkpoint write' has written");
  const std::vector<int> version = file.whole_attribute("/record", "version");
  const std::string there = file.text_attribute("/record", "scene");
  Slab one;
  one.extent = one.count = {1}, one.offset = {0};
  double there_step = -1, there_particles = -1, every = c.settings.every;
  file.read("/record/step", one, &there_step);
  file.read("/record/particles", one, &there_particles);
  file.read("/record/every", one, &every);
  const auto refuse = [&](const std::string& found, const std::string& wanted) {
    throw std::invalid_argument("checkpoint read: found " + path + " of " + found + ", wanted " + wanted);
  };
  if (version != std::vector<int>{kVersion}) refuse("another version of twogrid", "one of this version");
  if (there != scene(c)) refuse("another scene (" + there + ")", "one of this scene (" + scene(c) + ")");
  const std::string now = "step " + std::to_string(step) + " with " + std::to_string(particles) + " particles";
  if (there_step != double(step) || there_particles != double(particles))
    refuse("step " + std::to_string((long long)there_step) + " with " + std::to_string((long long)there_particles) +
               " particles",
           "one of " + now +
               ", those of the restart file that was read: write_restart and 'checkpoint write' belong "
               "together, with no run between them");
  c.settings.every = int(every);
  StateFile states(c.comm, c.fluid.layout(), nodes, file);
  for_each_state(c, [&](const char* group, auto& state) { states.read(group, state); });
  file.close();
  c.fluid.restored();
  c.coupling.restored();
}

}  // namespace twogrid
