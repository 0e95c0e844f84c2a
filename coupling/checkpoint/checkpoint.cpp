#include "coupling/checkpoint/checkpoint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "cfd/fluid_solver.h"
#include "cfd/parallel/rank_0.h"
#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/checksum.h"
#include "coupling/checkpoint/state_check.h"
#include "coupling/checkpoint/state_file.h"
#include "coupling/control/schedule.h"
#include "coupling/coupling.h"
#include "coupling/coupling_state.h"
#include "coupling/output/averages.h"
#include "coupling/output/on_disk.h"
#include "coupling/output/output.h"
#include "coupling/output/start_up.h"
#include "coupling/output/wall_writer.h"

namespace twogrid {

namespace {

constexpr char kKeyword[] = "checkpoint", kOutput[] = "/output", kAverages[] = "/averages", kWalls[] = "/walls",
               kStartUp[] = "/start_up";
constexpr double kMost = 9e15;  // steps, particles
constexpr int kVersion = 3;

ParticleGrid nodes_of(const CheckpointParts& c) {
  return ParticleGrid(c.fluid.grid(), c.settings.ratio);
}

/// What must be the same, in words.
std::string scene(const Settings& settings, const FineGrid& grid) {
  std::ostringstream s;
  s.precision(17);
  s << "fine";
  for (int n : grid.n()) s << " " << n;
  s << ", ratio";
  for (int r : settings.ratio) s << " " << r;
  s << ", domain";
  for (const Axis& a : grid.axis) s << " " << a.lo() << " " << a.lo() + a.length() << (a.periodic() ? " periodic" : "");
  s << ", formulation " << (settings.formulation == Formulation::kA ? "A" : "B");
  // These decide which levels and fields there are.
  s << ", convection " << (settings.fluid.convection == Convection::kCentral ? "central" : "not central");
  s << ", interpolate " << (settings.interpolate == Interpolate::kSmooth ? "smooth" : "linear");
  s << ", one-way " << (settings.one_way ? "yes" : "no");
  s << ", density " << settings.fluid.density;
  return s.str();
}

/// The numbers of cells that scene() has put; 0 where they are not there.
void cells_of(Beginning& b) {
  Int3 &n = b.fine, &r = b.ratio;
  if (std::sscanf(b.scene.c_str(), "fine %d %d %d, ratio %d %d %d", &n[0], &n[1], &n[2], &r[0], &r[1], &r[2]) != 6)
    n = r = {0, 0, 0};
}

/// What bodies leave open, and where, in whole numbers that don't hang on the ranks: sums of the cells' shares, of these by
/// their places, of the faces' shares. Empty without bodies. Collective.
std::vector<double> open_digest(const CheckpointParts& c) {
  const OpenShares* const open = c.fluid.open_shares();
  if (!open) return {};
  const auto whole = [](double share) { return std::llround(share * (1 << 20)); };
  std::array<long long, 7> sum{};
  for_each(c.fluid.layout().cells(rank_of(c.comm)), [&](int i, int j, int k) {
    const long long theta = whole(open->theta()(i, j, k));
    sum[0] += theta, sum[1] += i * theta, sum[2] += j * theta, sum[3] += k * theta;
    for (int d = 0; d < 3; ++d) sum[4 + d] += whole(open->alpha(d, open->ratio()[d].index(i, j, k)));
  });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(sum.size()), MPI_LONG_LONG, MPI_SUM, c.comm);
  return {sum.begin(), sum.end()};
}

/// But for what another compiler or processor rounds.
bool same_digest(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return std::abs(x - y) <= std::max(16.0, 1e-9 * std::abs(x));
         });
}

std::string open_cells(const std::vector<double>& digest) {
  if (digest.empty()) return "no bodies";
  std::ostringstream s;
  s << "bodies that leave " << digest[0] / (1 << 20) << " cells open";
  return s.str();
}

/// Fields of models, in words.
std::string models(const CheckpointParts& c) {
  std::string s;
  for (const ModelField& f : c.fluid.model_fields()) s += (s.empty() ? "" : ", ") + f.name;
  return s.empty() ? "none" : s;
}

/// The report comes after the states that it tells of.
template <class F>
void for_each_state(const CheckpointParts& c, F&& f) {
  f("/fluid", c.fluid.state_to_restore());
  f("/coupling", c.coupling.state());
  f("/schedule", c.schedule);
  if (c.output) f(kOutput, c.output->state());
  if (c.output && c.output->averages()) f(kAverages, c.output->averages()->state());
  if (c.output && c.output->start_up()) f(kStartUp, c.output->start_up()->state());
  if (c.output && c.output->wall_means()) f(kWalls, *c.output->wall_means());
  f("/report", c.coupling.report_to_restore());
  for (const NumberList& list : c.numbers) f("/" + list.group, list);
}

double bytes_of(const CheckpointParts& c, const Moment& now) {
  double values = 0;
  for_each_state(c, [&](const std::string&, auto& state) {
    std::decay_t<decltype(state)>::for_each_entry(state, [&](const std::string&, const auto& entry) {
      if constexpr (!std::is_arithmetic_v<std::decay_t<decltype(entry)>>) values += double(entry.size());
    });
  });
  MPI_Allreduce(MPI_IN_PLACE, &values, 1, MPI_DOUBLE, MPI_SUM, c.comm);
  return 8 * values + 4 * double(now.particles) + 262144;
}

/// This rank's part of a list of all ranks' particles.
Slab own_part(const std::vector<double>& particles, int rank) {
  const auto up_to = [&](std::ptrdiff_t r) {
    return std::size_t(std::accumulate(particles.begin(), particles.begin() + r, 0.0));
  };
  Slab s;
  s.extent = {up_to(std::ptrdiff_t(particles.size()))}, s.offset = {up_to(rank)};
  s.count = {std::size_t(particles[rank])};
  return s;
}

const char* const kBorders[3] = {"/ranks/borders_x", "/ranks/borders_y", "/ranks/borders_z"};
const char* const kCuts[3] = {"/ranks/cuts_x", "/ranks/cuts_y", "/ranks/cuts_z"};

void write_ranks(MPI_Comm comm, const RankParts& parts, const Layout& layout, Hdf5File& file) {
  const auto put = [&](const std::string& path, const std::vector<double>& all) {
    file.replicated(path, all, {all.size()});
  };
  file.group("/ranks");
  put("/ranks/bricks", {parts.bricks.begin(), parts.bricks.end()});
  put("/ranks/equal", {double(parts.equal)});
  std::vector<double> bricks, particles(ranks_of(comm));
  for (int r = 0; r < layout.ranks(); ++r) bricks.insert(bricks.end(), layout.brick(r).begin(), layout.brick(r).end());
  put("/ranks/fluid_brick", bricks);
  for (int d = 0; d < 3; ++d) {
    put(kBorders[d], parts.borders[d]);
    put(kCuts[d], {layout.cuts()[d].begin(), layout.cuts()[d].end()});
  }
  const double own = double(parts.tags.size());
  MPI_Allgather(&own, 1, MPI_DOUBLE, particles.data(), 1, MPI_DOUBLE, comm);
  put("/ranks/particles", particles);
  file.slab("/ranks/tags", own_part(particles, rank_of(comm)), parts.tags.data());
}

/// A list that ascends from `first` to `last`, of whole numbers where they are cells.
bool ascends(const std::vector<double>& list, double first, double last, bool whole) {
  return list.size() > 1 && list.front() == first && list.back() == last && std::is_sorted(list.begin(), list.end()) &&
         std::all_of(list.begin(), list.end(), [&](double v) { return !whole || v == std::floor(v); });
}

/// Shares of the ranks that can't be: a sentence's part; empty: they can.
std::string unlikely(const std::vector<double>& particles, const std::vector<double>& bricks,
                     const std::vector<double>& of_rank, const std::array<std::vector<double>, 3>& borders,
                     const std::array<std::vector<double>, 3>& cuts) {
  const auto whole = [](const std::vector<double>& list, double least, double most) {
    return std::all_of(list.begin(), list.end(),
                       [&](double v) { return v == std::floor(v) && v >= least && v <= most; });
  };
  if (!whole(particles, 0, 2147483647)) return "/ranks/particles holds no counts";
  if (!whole(bricks, 1, 2147483647)) return "/ranks/bricks holds no counts";
  std::set<std::array<double, 3>> places;
  for (std::size_t r = 0; r < of_rank.size(); r += 3) places.insert({of_rank[r], of_rank[r + 1], of_rank[r + 2]});
  if (3 * places.size() != of_rank.size()) return "/ranks/fluid_brick gives a brick to two ranks";
  double all = 1;
  for (int d = 0; d < 3; ++d) {
    all *= double(cuts[d].size()) - 1;
    if (!ascends(borders[d], 0, 1, false)) return std::string(kBorders[d]) + " doesn't ascend from 0 to 1";
    if (cuts[d].empty() || !ascends(cuts[d], 0, cuts[d].back(), true))
      return std::string(kCuts[d]) + " doesn't cut the cells in parts";
    for (std::size_t r = std::size_t(d); r < of_rank.size(); r += 3)
      if (!whole({of_rank[r]}, 0, double(cuts[d].size()) - 2)) return "/ranks/fluid_brick names no brick";
  }
  if (all != double(places.size())) return "/ranks/fluid_brick leaves bricks without a rank";
  return "";
}

RankParts read_ranks(MPI_Comm comm, Hdf5File& file) {
  const auto get = [&](const std::string& path) { return file.whole(path); };
  const std::size_t ranks = ranks_of(comm);
  const std::vector<double> particles = get("/ranks/particles"), bricks = get("/ranks/bricks"),
                            of_rank = get("/ranks/fluid_brick"), equal = get("/ranks/equal");
  RankParts parts;
  if (particles.size() != ranks || bricks.size() != 3 || of_rank.size() != 3 * ranks || equal.size() != 1) return parts;
  std::array<std::vector<double>, 3> borders, cuts;
  for (int d = 0; d < 3; ++d) borders[d] = get(kBorders[d]), cuts[d] = get(kCuts[d]);
  const std::string wrong = unlikely(particles, bricks, of_rank, borders, cuts);
  if (!wrong.empty()) return file.unfit(wrong), RankParts{};
  if (left_out("/ranks/borders")) return parts;
  for (int d = 0; d < 3; ++d) {
    parts.borders[d] = borders[d];
    parts.bricks[d] = int(bricks[d]);
  }
  parts.equal = equal[0] != 0;
  for (int d = 0; d < 3 && !left_out("/ranks/layout"); ++d) parts.cuts[d].assign(cuts[d].begin(), cuts[d].end());
  for (std::size_t r = 0; r < ranks; ++r)
    parts.fluid_brick.push_back({int(of_rank[3 * r]), int(of_rank[3 * r + 1]), int(of_rank[3 * r + 2])});
  if (left_out("/ranks/tags")) return parts;
  const Slab part = own_part(particles, rank_of(comm));
  if (!file.holds("/ranks/tags", part.extent))
    return file.unfit("/ranks/tags is not there, or has not as many entries as /ranks/particles says"), RankParts{};
  parts.tags.resize(part.count[0]);
  file.read("/ranks/tags", part, parts.tags.data());
  parts.ordered = true;
  return parts;
}

[[noreturn]] void refuse_file(const std::string& path, const std::string& found, const std::string& wanted) {
  throw std::invalid_argument("checkpoint read: found " + path + found + ", wanted " + wanted);
}

}  // namespace

void write_plain_checkpoint(const std::string& path, const CheckpointParts& c, const Moment& now,
                            const Beginning& beginning) {
  if (c.output && c.output->averages()) c.output->averages()->gather();
  const Layout nodes = node_layout(c.fluid.layout(), nodes_of(c));
  Hdf5File file(c.comm, path, Hdf5File::Mode::kCreate, bytes_of(c, now), kKeyword);
  file.group("/record");
  file.attribute("/record", "version", std::vector<int>{kVersion});
  file.attribute("/record", "scene", scene(c.settings, c.fluid.grid()));
  file.attribute("/record", "models", models(c));
  file.replicated("/record/step", {double(now.step)}, {1});
  file.replicated("/record/particles", {double(now.particles)}, {1});
  file.replicated("/record/every", {double(beginning.every)}, {1});
  file.replicated("/record/skin", {beginning.skin}, {1});
  const std::vector<double> open = open_digest(c);
  if (!open.empty()) file.replicated("/record/open", open, {open.size()});
  write_ranks(c.comm, beginning.ranks, c.fluid.layout(), file);
  StateFile states(c.comm, c.fluid.layout(), nodes, file);
  for_each_state(c, [&](const std::string& group, const auto& state) { states.write(group, state); });
  file.close();
  const std::string why = from_rank(c.comm, 0, rank_of(c.comm) == 0 ? seal_file(path) : "");
  if (!why.empty())
    throw std::runtime_error("the checkpoint '" + path + "' could not be written (" + why +
                             "); see whether its disk is full, or give another path (fix_modify ID checkpoint)");
}

void write_checkpoint(const std::string& path, const CheckpointParts& c, const Moment& now,
                      const Beginning& beginning) {
  const std::string part = path + ".part";
  try {
    write_plain_checkpoint(part, c, now, beginning);
  } catch (...) {
    if (rank_of(c.comm) == 0) std::remove(part.c_str());
    throw;
  }
  const std::string why = from_rank(c.comm, 0, rank_of(c.comm) == 0 ? put_in_place(part, path) : "");
  if (!why.empty())
    throw std::runtime_error("the checkpoint '" + path + "' could not be put in place (" + why +
                             "); give another path (fix_modify ID checkpoint write)");
}

Beginning read_beginning(MPI_Comm comm, const std::string& path, const Moment& now) {
  // HDF5 is not shown a file that may be damaged.
  const std::string broken = from_rank(comm, 0, rank_of(comm) == 0 ? broken_seal(path) : "");
  if (!broken.empty())
    refuse_file(path, ": " + broken,
                "a checkpoint of fix twogrid, as it was written: give another one, or an older one");
  Hdf5File file(comm, path, Hdf5File::Mode::kRead, 0, kKeyword);
  const auto number = [&](const std::string& name, double least, double most, double otherwise) {
    const std::string place = "/record/" + name;
    if (left_out(place)) return otherwise;
    const std::vector<double> all = file.whole(place);
    const double value = all.size() == 1 ? all[0] : NAN;
    if (!(value >= least && value <= most)) file.unfit(place + " is not there, or no such number");
    return value >= least && value <= most ? value : least;
  };
  if (file.whole_attribute("/record", "version") != std::vector<int>{kVersion})
    refuse_file(path, " of another version of twogrid", "one of this version");
  const auto moment = [](const Moment& m) {
    return "step " + std::to_string(m.step) + " with " + std::to_string(m.particles) + " particles";
  };
  const Moment then{(long long)number("step", -1, kMost, -1), (long long)number("particles", -1, kMost, -1)};
  if (then.step != now.step || then.particles != now.particles)
    refuse_file(path, " of " + moment(then),
                "one of " + moment(now) +
                    ", those of the restart file that was read: write_restart and 'checkpoint write' belong "
                    "together, with no run between them");
  Beginning beginning;
  beginning.scene = file.text_attribute("/record", "scene");
  cells_of(beginning);
  beginning.every = int(number("every", 1, 2e9, 0));
  beginning.skin = number("skin", 0, kMost, 0);
  beginning.ranks = read_ranks(comm, file);
  file.close();
  return beginning;
}

void check_scene(const std::string& path, const Beginning& beginning, const Settings& settings, const FineGrid& grid) {
  const std::string here = scene(settings, grid);
  if (beginning.scene != here)
    refuse_file(path, " of another scene (" + beginning.scene + ")", "one of this scene (" + here + ")");
  for (int d = 0; d < 3; ++d)
    for (int c : beginning.ranks.cuts[d])
      if (c % settings.ratio[d] != 0 || beginning.ranks.cuts[d].back() != grid.axis[d].n())
        refuse_file(path, std::string(", whose ") + kCuts[d] + " cuts other cells than there are", "one of this scene");
}

void read_numbers(MPI_Comm comm, const std::string& path, const Layout& layout, NumberList list) {
  Hdf5File file(comm, path, Hdf5File::Mode::kRead, 0, kKeyword);
  if (file.has("/" + list.group)) StateFile(comm, layout, layout, file).read("/" + list.group, list);
  file.close();
}

void read_checkpoint(const std::string& path, const CheckpointParts& c) {
  const Layout nodes = node_layout(c.fluid.layout(), nodes_of(c));
  Hdf5File file(c.comm, path, Hdf5File::Mode::kRead, 0, kKeyword);
  const std::string there = file.text_attribute("/record", "models"), here = models(c);
  if (there != here) refuse_file(path, " with fields of models (" + there + ")", "those of this scene (" + here + ")");
  const std::vector<double> open_here = open_digest(c),
                            open_there = file.has("/record/open") ? file.whole("/record/open") : std::vector<double>{};
  if (!same_digest(open_here, open_there))
    refuse_file(path, " of a scene with " + open_cells(open_there),
                "that of this scene, with " + open_cells(open_here) +
                    (open_here.size() == open_there.size() ? " or elsewhere" : "") +
                    ": name the bodies that the checkpoint was written with (fix_modify ID solid)");
  StateFile states(c.comm, c.fluid.layout(), nodes, file);
  // Arrays that fluid and coupling have from the beginning they have always.
  std::map<std::string, Box> made;
  const auto each_array = [](auto& state, auto&& f) {
    std::decay_t<decltype(state)>::for_each_entry(state, [&](const std::string& name, auto& entry) {
      if constexpr (!std::is_arithmetic_v<std::decay_t<decltype(entry)>>) f(name, entry);
    });
  };
  const auto note = [&](const std::string& name, const auto& a) {
    if (a.size() > 0) made[name] = a.box();
  };
  each_array(c.fluid.state(), note), each_array(std::as_const(c.coupling.state()), note);
  const auto look = [&](const std::string& name, const auto& a) {
    const auto was = made.find(name);
    if (was != made.end() && !(a.box() == was->second)) file.unfit(name + " is not there");
  };
  for_each_state(c, [&](const std::string& group, auto& state) {
    if constexpr (std::is_same_v<std::decay_t<decltype(state)>, Report>) {
      each_array(c.fluid.state(), look), each_array(std::as_const(c.coupling.state()), look);
      const std::string wrong =
          broken_promise(c.fluid.state(), c.coupling.state(),
                         {c.fluid.layout().cells(rank_of(c.comm)), nodes.cells(rank_of(c.comm)), c.settings.one_way});
      if (!wrong.empty()) file.unfit(wrong);
      c.fluid.restored();
      c.coupling.restored();
    }
    // Another script may want output, or means, that the first had none of: they begin.
    if ((group == kOutput || group == kAverages || group == kWalls) && !file.has(group)) return;
    states.read(group, state);
  });
  file.close();
}

}  // namespace twogrid
