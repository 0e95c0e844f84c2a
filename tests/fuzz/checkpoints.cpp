// Checkpoint files: bytes mutated, which the checksum must see before HDF5 does; and mutated under a checksum made anew,
// bytes as well as datasets, in which case reading must refuse them or make a state that can go on.
#include <dlfcn.h>
#include <execinfo.h>
#include <hdf5.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "cfd/fluid_solver.h"
#include "coupling/checkpoint/checkpoint.h"
#include "coupling/checkpoint/checksum.h"
#include "coupling/control/schedule.h"
#include "coupling/coupling.h"
#include "coupling/coupling_state.h"
#include "coupling/methods.h"
#include "tests/fuzz/fuzz.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_fuzz {
namespace {

using namespace twogrid_test;

constexpr double kStep = 1e-4;
constexpr int kEvery = 4;
constexpr std::size_t kSeal = 31;  // bytes of the line with the checksum

Settings some_settings(bool A) {
  Settings s;
  s.id = "gas", s.fine = {4, 4, 8}, s.ratio = {2, 2, 2}, s.every = kEvery;
  s.formulation = A ? Formulation::kA : Formulation::kB;
  s.fluid.density = 1.2, s.fluid.viscosity = 1.8e-5;
  for (int side = 0; side < 6; ++side) s.fluid.side[side].emplace_back();
  s.fluid.side[kZlo][0].kind = BoundaryKind::kInlet, s.fluid.side[kZlo][0].velocity = {0, 0, 0.5};
  s.fluid.side[kZhi][0].kind = BoundaryKind::kPressure;
  choose(*find_method(kDefaultMethod), 0, s);
  return s;
}

struct Scene {
  explicit Scene(bool A)
      : settings(some_settings(A)),
        grid(make_grid({0, 0, 0}, {0.004, 0.004, 0.008}, {4, 4, 8}, {false, false, false})),
        fluid(MPI_COMM_SELF, grid, make_layout(grid, 1, {2, 2, 2}), settings.fluid),
        coupling(MPI_COMM_SELF, settings, fluid, {0, 0, 0}, {0.004, 0.004, 0.008}, 0.001) {
    for (int q = 0; q < 12; ++q)
      bodies.add({0.0005 + 0.001 * (q % 4), 0.001 + 0.0008 * (q / 4), 0.002 + 0.0003 * q}, 0.0004, 2500,
                 {0, 0, 0.01 * q}, q + 1);
  }
  CheckpointParts parts() {
    CheckpointParts p{MPI_COMM_SELF, settings, fluid, coupling, schedule, nullptr, {}};
    return p;
  }
  void begin() {
    Particles p = bodies.view();
    coupling.start(p, kStep);
    coupling.force(p, kStep, false);
  }
  void run(int intervals) {
    for (int n = 0; n < intervals; ++n) {
      Particles p = bodies.view();
      coupling.advance(p, kEvery, kStep);
      for (int i = 0; i < p.n; ++i) p.f[i][0] = p.f[i][1] = p.f[i][2] = 0;
      coupling.force(p, kStep, true);
      coupling.finish_step(p);
    }
  }
  void rest() {
    Particles p = bodies.view();
    coupling.rest(p);
  }

  Settings settings;
  FineGrid grid;
  FluidSolver fluid;
  Coupling coupling;
  ScheduleState schedule;
  Bodies bodies;
};

const Moment kNow{100, 12};

std::string file_of(const std::string& path) {
  std::ostringstream s;
  s << std::ifstream(path, std::ios::binary).rdbuf();
  return s.str();
}

/// A good checkpoint: its path and bytes, and what its datasets are called.
struct Good {
  explicit Good(bool A) : path(folder() + (A ? "/good_a.h5" : "/good_b.h5")) {
    Scene scene(A);
    scene.begin(), scene.run(3), scene.rest();
    Beginning beginning;
    beginning.every = kEvery;
    beginning.ranks.bricks = {1, 1, 1};
    for (auto& b : beginning.ranks.borders) b = {0, 1};
    for (int tag : scene.bodies.tag) beginning.ranks.tags.push_back(tag);
    write_plain_checkpoint(path, scene.parts(), kNow, beginning);
    bytes = file_of(path);
    for (const char* group : {"/fluid", "/coupling", "/schedule", "/report", "/record", "/ranks"}) {
      const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), g = H5Gopen2(file, group, H5P_DEFAULT);
      H5Literate(
          g, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
          [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
            static_cast<std::vector<std::string>*>(out)->push_back(name);
            return 0;
          },
          &names);
      H5Gclose(g), H5Fclose(file);
      for (; done < names.size(); ++done) datasets.push_back(std::string(group) + "/" + names[done]);
    }
  }
  std::string path, bytes;
  std::vector<std::string> datasets;

 private:
  std::vector<std::string> names;
  std::size_t done = 0;
};

/// One dataset is another. Returns what was done.
std::string replace_dataset(const std::string& path, const Good& good, Dice& dice) {
  static const std::vector<double> kOdd{NAN, INFINITY, -INFINITY,    1e300,  -1e300,        0,    -1, 1, 2, 0.5,
                                        1e9, 1e-300,   2147483648.0, 9.3e18, -2147483649.0, 1e12, 17};
  const std::string name = dice.of(good.datasets);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (file < 0) return "";
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
  hsize_t n[8] = {};
  const int rank = H5Sget_simple_extent_dims(space, n, nullptr);
  std::size_t count = std::size_t(H5Sget_simple_extent_npoints(space));
  std::vector<double> values(count);
  H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  std::vector<int> widths(H5Aexists(set, "widths") > 0 ? 12 : 0);
  if (!widths.empty()) {
    const hid_t a = H5Aopen(set, "widths", H5P_DEFAULT);
    H5Aread(a, H5T_NATIVE_INT, widths.data());
    H5Aclose(a);
  }
  H5Dclose(set), H5Sclose(space);
  H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  const int kind = int(dice.below(8));
  std::string what = name;
  hid_t type = H5Tcopy(H5T_NATIVE_DOUBLE);
  int dims = rank;
  if (kind == 0) {
    what += " missing";
    if (dice.one_in(2) && name.find('_') != std::string::npos) {  // and all of its kin
      const std::string kin = name.substr(0, name.rfind('_'));
      for (const std::string& other : good.datasets)
        if (other != name && other.rfind(kin, 0) == 0)
          H5Ldelete(file, other.c_str(), H5P_DEFAULT), what += ", " + other;
    }
  } else {
    if (kind == 1) {
      const int d = int(dice.below(std::size_t(std::max(rank, 1))));
      static const std::vector<hsize_t> kExtents{0, 1, 2, 3, 5, 7, 16, 100};
      n[d] = dice.one_in(4) ? hsize_t(1) << (20 + dice.below(30)) : dice.of(kExtents);
      what += " of extent " + std::to_string(n[d]);
    } else if (kind == 2) {
      dims = int(dice.below(6));
      for (int d = 0; d < 6; ++d) n[d] = n[d] ? n[d] : 1;
      what += " of " + std::to_string(dims) + " dimensions";
    } else if (kind == 3) {
      H5Tclose(type);
      type = dice.one_in(2) ? H5Tcopy(H5T_C_S1) : H5Tcopy(dice.one_in(2) ? H5T_NATIVE_INT8 : H5T_NATIVE_FLOAT);
      what += " of another type";
    } else if (kind == 4 && !widths.empty()) {
      static const std::vector<int> kWidths{-1, 0, 1, 2, 1000, 1000000, 2147483647, -2147483647};
      for (std::size_t k = 1 + dice.below(3); k > 0; --k) widths[dice.below(12)] = dice.of(kWidths);
      if (dice.one_in(5)) widths.resize(dice.below(12));
      what += " of other widths";
    } else {
      const double odd = dice.of(kOdd);
      if (dice.one_in(2))
        std::fill(values.begin(), values.end(), odd);
      else if (count > 0)
        values[dice.below(count)] = odd;
      what += " holds " + std::to_string(odd);
    }
    const hid_t to = H5Screate_simple(dims, n, nullptr);
    const hid_t made = H5Dcreate2(file, name.c_str(), type, to, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hssize_t fits = H5Sget_simple_extent_npoints(to);
    if (made >= 0 && fits >= 0 && std::size_t(fits) <= values.size() && H5Tget_class(type) == H5T_FLOAT)
      H5Dwrite(made, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    if (made >= 0 && !widths.empty()) {
      hsize_t k = widths.size();
      const hid_t one = H5Screate_simple(1, &k, nullptr),
                  a = H5Acreate2(made, "widths", H5T_NATIVE_INT, one, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(a, H5T_NATIVE_INT, widths.data());
      H5Aclose(a), H5Sclose(one);
    }
    if (made >= 0) H5Dclose(made);
    H5Sclose(to);
  }
  H5Tclose(type);
  H5Fclose(file);
  return what;
}

/// All values of a dataset are this one.
void fill_dataset(const std::string& path, const std::string& name, double value) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
  const std::vector<double> values(std::size_t(H5Sget_simple_extent_npoints(space)), value);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space), H5Dclose(set), H5Fclose(file);
}

/// Not finite, or out of all range: what reading has let through.
std::string senseless(Scene& s) {
  std::string wrong;
  const auto look = [&](const std::string& name, double v) {
    if (wrong.empty() && !(std::abs(v) < 1e31)) wrong = "accepted " + name + " = " + std::to_string(v);
    const bool eps = name == "deposit_eps" || name == "history_now" || name == "change_rest_eps";
    if (wrong.empty() && eps && !(v > 0 && v <= 1.000001)) wrong = "accepted " + name + " = " + std::to_string(v);
  };
  const auto all = [&](auto& state) {
    std::decay_t<decltype(state)>::for_each_entry(state, [&](const std::string& name, auto& entry) {
      if constexpr (std::is_arithmetic_v<std::decay_t<decltype(entry)>>)
        look(name, double(entry));
      else
        for (std::size_t m = 0; m < entry.size(); ++m) look(name, entry.data()[m]);
    });
  };
  all(s.fluid.state_to_restore()), all(s.coupling.state()), all(s.schedule);
  return wrong;
}

/// Reads it, and goes on from it.
Verdict read_and_run(const std::string& path, bool A) {
  auto scene = std::make_unique<Scene>(A);
  Verdict v = tried(
      [&] {
        const Beginning b = read_beginning(MPI_COMM_SELF, path, kNow);
        check_scene(path, b, scene->settings, scene->grid);
        if (b.every < 1) throw std::logic_error("accepted every = " + std::to_string(b.every));
        if (b.ranks.known()) Layout(scene->grid, b.ranks.cuts, b.ranks.fluid_brick);
        read_checkpoint(path, scene->parts());
      },
      {});
  if (!v.accepted) return v;
  v.defect = senseless(*scene);
  if (!v.defect.empty()) return v;
  // A state that is read may still be one that can't go on: then with a sentence.
  const Verdict on = tried([&] { scene->begin(), scene->run(2); }, {"fluid"});
  v.defect = on.defect;
  return v;
}

constexpr int kWithinHdf5 = 77;

/// Of a process that has met data of HDF5's own which are damaged though the checksum is right: whose code it was.
extern "C" void whose_crash(int number) {
  void* frame[64];
  const int n = backtrace(frame, 64);
  bool handler = true;  // the handler's own frames, and one of the sanitizer's, lie before libc's return from a signal
  for (int i = 0; i < n; ++i) {
    Dl_info where = {};
    if (!dladdr(frame[i], &where) || !where.dli_fname || frame[i] == nullptr) continue;
    if (std::strstr(where.dli_fname, "libc.so")) handler = false;
    if (handler) continue;
    if (std::strstr(where.dli_fname, "libhdf5")) _exit(kWithinHdf5);
    if (std::strstr(where.dli_fname, "fuzz")) break;  // ours
  }
  signal(number, SIG_DFL);
  raise(number);
}

// Of the address sanitizer; null without it.
extern "C" {
__attribute__((weak)) void __sanitizer_set_death_callback(void (*)());
__attribute__((weak)) void* __asan_get_report_address();
__attribute__((weak)) std::size_t __asan_get_alloc_stack(void*, void**, std::size_t, int*);
}

/// The same of a report of the address sanitizer: memory that HDF5 has made for itself.
void whose_report() {
  void* frame[4];
  int thread = 0;
  const std::size_t n = __asan_get_alloc_stack(__asan_get_report_address(), frame, 4, &thread);
  Dl_info where = {};
  for (std::size_t i = 0; i < n && i < 2; ++i)  // the sanitizer's malloc comes first
    if (dladdr(frame[i], &where) && where.dli_fname && std::strstr(where.dli_fname, "libhdf5")) _exit(kWithinHdf5);
}

/// f in a process of its own. Empty: it ended by itself with 0.
std::string apart(const std::function<int()>& f) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    void* once[1];
    backtrace(once, 1);  // loads what it needs now
    for (int s : {SIGSEGV, SIGFPE, SIGABRT, SIGBUS}) signal(s, whose_crash);
    signal(SIGALRM, SIG_DFL);
    if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(whose_report);
    _exit(f());
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status))
    return WTERMSIG(status) == SIGALRM ? "hangs" : std::string("signal ") + strsignal(WTERMSIG(status));
  return WEXITSTATUS(status) == 0 ? "" : "exit " + std::to_string(WEXITSTATUS(status));
}

void put(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

const Good& good_one(bool A) {
  static const Good kGood[2] = {Good(false), Good(true)};
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  return kGood[A];
}

}  // namespace

long crashes_in_hdf5 = 0;

/// Counts that promise much: nothing may be allocated for what the file doesn't hold.
Verdict try_checkpoint_promise(Dice& dice) {
  static const std::vector<double> kMuch{1e8, 1e9, 2147483647.0};
  const Good& good = good_one(false);
  const std::string path = folder() + "/mutated.h5",
                    name = dice.one_in(2) ? "/ranks/particles" : dice.of(good.datasets);
  const double much = dice.of(kMuch);
  note(name + " is " + std::to_string(much));
  put(path, good.bytes.substr(0, good.bytes.size() - kSeal));
  fill_dataset(path, name, much);
  seal_file(path);
  return read_and_run(path, false);
}

Verdict try_checkpoint_file(Dice& dice) {
  const bool A = dice.one_in(2);
  const Good& good = good_one(A);
  const std::string path = folder() + "/mutated.h5";
  std::string bytes = good.bytes;
  Verdict v;
  switch (dice.below(8)) {
    case 0:
    case 1: {  // the checksum sees it
      mutate_bytes(bytes, dice);
      if (bytes == good.bytes) return v.accepted = true, v;
      note("bytes of a checkpoint, from " +
           std::to_string(std::mismatch(bytes.begin(),
                                        bytes.begin() + std::ptrdiff_t(std::min(bytes.size(), good.bytes.size())),
                                        good.bytes.begin())
                              .first -
                          bytes.begin()));
      put(path, bytes);
      std::string said;
      try {
        read_beginning(MPI_COMM_SELF, path, kNow);
        v.defect = "a damaged file is believed";
      } catch (const std::exception& e) {
        said = e.what();
      }
      if (v.defect.empty() && said.find("checksum") == std::string::npos)
        v.defect = "HDF5 has seen a damaged file: " + said;
      return v;
    }
    case 2: {  // the checksum is made anew: HDF5's own data may be damaged
      bytes.resize(bytes.size() - kSeal);
      for (std::size_t n = 1 + dice.below(3); n > 0; --n) mutate_bytes(bytes, dice);
      put(path, bytes);
      note("bytes of a checkpoint, and the checksum made anew");
      seal_file(path);
      Verdict inside;
      const std::string end = apart([&] {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        inside = read_and_run(path, A);
        if (!inside.defect.empty())
          std::printf("DEFECT in what follows: %s\n", inside.defect.c_str()), std::fflush(stdout);
        return inside.defect.empty() ? (inside.accepted ? 0 : 50) : 51;
      });
      v.accepted = end.empty();
      if (end == "exit 51")
        v.defect = "see the line before";
      else if (end == "exit " + std::to_string(kWithinHdf5))
        ++crashes_in_hdf5;  // told apart: such a file never gets past its checksum by itself
      else if (!end.empty() && end != "exit 50")
        v.defect = "ends by " + end;
      return v;
    }
    default: {
      bytes.resize(bytes.size() - kSeal);
      put(path, bytes);
      const std::string what = replace_dataset(path, good, dice);
      note(what + (A ? " (formulation A)" : " (formulation B)"));
      seal_file(path);
      return read_and_run(path, A);
    }
  }
}

}  // namespace twogrid_fuzz
