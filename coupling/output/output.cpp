#include "coupling/output/output.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <stdexcept>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/averages.h"
#include "coupling/output/hdf5_file.h"
#include "coupling/output/xdmf.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

namespace {

const char* const kXyz[3] = {"x", "y", "z"};

/// bed.h5 -> bed
std::string stem(const std::string& file) {
  const auto slash = file.find_last_of('/'), dot = file.find_last_of('.');
  const bool has_ending = dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
  return has_ending ? file.substr(0, dot) : file;
}

std::string name_in_directory(const std::string& file) {
  const auto slash = file.find_last_of('/');
  return slash == std::string::npos ? file : file.substr(slash + 1);
}

std::string from_rank_0(MPI_Comm comm, std::string s) {
  unsigned long n = s.size();
  MPI_Bcast(&n, 1, MPI_UNSIGNED_LONG, 0, comm);
  s.resize(n);
  MPI_Bcast(s.data(), int(n), MPI_CHAR, 0, comm);
  return s;
}

std::string now() {
  const std::time_t t = std::time(nullptr);
  char s[32];
  std::strftime(s, sizeof s, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&t));
  return s;
}

std::string mpi_version() {
  char s[MPI_MAX_LIBRARY_VERSION_STRING];
  int n;
  MPI_Get_library_version(s, &n);
  return std::string(s, n);
}

void check_fields(const std::vector<std::string>& wanted, const Fluid& fluid) {
  std::vector<std::string> known = output_fields();
  for (const ModelField& f : fluid.model_fields()) known.push_back(f.name);
  std::string list;
  for (const auto& f : known) list += (list.empty() ? "" : ", ") + f;
  for (const auto& f : wanted)
    if (std::find(known.begin(), known.end(), f) == known.end())
      throw std::invalid_argument("output fields: '" + f + "' is no field that can be written; give some of " + list);
}

/// Values of `own` out of an array with a halo, for a dataset that holds `all` indices.
Slab part_of(const Int3& all, const Box& own, const Box& array) {
  Slab s;
  for (int d = 2; d >= 0; --d) {
    s.extent.push_back(all[d]);
    s.offset.push_back(own.empty() ? 0 : own.lo[d]);
    s.count.push_back(own.empty() ? 0 : own.size(d));
    s.memory_extent.push_back(array.size(d));
    s.memory_offset.push_back(own.empty() ? 0 : own.lo[d] - array.lo[d]);
  }
  return s;
}

}  // namespace

const std::vector<std::string>& output_fields() {
  static const std::vector<std::string> kFields{"u", "p", "eps", "faces"};
  return kFields;
}

void check(const OutputSettings& s) {
  if (s.every < 0)
    throw std::invalid_argument("output every: " + std::to_string(s.every) +
                                " was given, a number of DEM steps of at least 1 is wanted (0: no frames)");
  if (s.file.empty() || s.file.back() == '/')
    throw std::invalid_argument("output file: '" + s.file + "' is no file name; give one, such as bed.h5");
  if (stem(s.file) == s.file || s.file == stem(s.file) + ".xdmf")
    throw std::invalid_argument("output file: '" + s.file + "' should end with .h5, so that " + stem(s.file) +
                                ".xdmf for ParaView can stand beside it");
}

class Output::Impl {
 public:
  Impl(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record);
  void frame(double t, long step, const Particles& particles);
  void average(double weight, const Particles& particles);
  void finish();

 private:
  void write_record(Hdf5File& file, const Settings& settings, const Record& record) const;
  void write_nodes(Hdf5File& file, const std::string& group, const Grid& grid) const;
  void write_fluid(Hdf5File& file, const std::string& at);
  void write_faces(Hdf5File& file, const std::string& at);
  void write_particles(Hdf5File& file, const std::string& at, const Particles& particles);
  void write_means(Hdf5File& file);
  void show_means();
  /// Runs f on rank 0; throws what it throws on all ranks.
  template <class F>
  void on_rank_0(F&& f) const;
  /// Written over, once they are in the file.
  double room_for_means() const { return means_written_ > 0 ? 0 : averages_->bytes(); }
  bool wants(const std::string& field) const {
    return std::find(settings_.fields.begin(), settings_.fields.end(), field) != settings_.fields.end();
  }

  MPI_Comm comm_;
  int rank_ = 0;
  const Fluid& fluid_;
  OutputSettings settings_;
  ParticleGrid coarse_;
  Int3 n_;
  Box own_;
  int frames_ = 0;
  double means_written_ = 0;  // weight of the means in the file
  bool means_shown_ = false;  // their XDMF file is there

  std::unique_ptr<Averages> averages_;  // only if wanted
  std::unique_ptr<XdmfSeries> series_;  // rank 0 only
  std::vector<double> buffer_;

  struct ParticleCount {
    long long own = 0, before = 0, total = 0;
    int has_tag = 0, has_state = 0, has_force = 0;
  } count_;
};

Output::Impl::Impl(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record)
    : comm_(comm), fluid_(fluid), settings_(settings.output), n_(fluid.grid().n()) {
  check(settings_);
  check_fields(settings_.fields, fluid);
  if (settings_.fields.empty()) {
    settings_.fields = {"u", "p", "eps"};
    for (const ModelField& f : fluid.model_fields()) settings_.fields.push_back(f.name);
  }
  if (wants("faces") && !wants("eps")) settings_.fields.push_back("eps");
  rank_ = rank_of(comm);
  own_ = fluid.layout().cells(rank_);
  coarse_ = ParticleGrid(fluid.grid(), settings.ratio);
  if (settings_.average_from >= 0) averages_ = std::make_unique<Averages>(comm, fluid.grid(), fluid.layout(), coarse_);

  const double nodes = n_[0] + n_[1] + n_[2] + 3.0;
  Hdf5File file(comm, settings_.file, Hdf5File::Mode::kCreate,
                131072 + 16 * nodes + double(record.input_text.size() + record.command_line.size()));
  write_record(file, settings, record);
  write_nodes(file, "/grid", fluid.grid());
  write_nodes(file, "/particle_grid", coarse_);
  file.attribute("/particle_grid", "ratio", std::vector<int>(settings.ratio.begin(), settings.ratio.end()));
  if (settings_.every > 0) {
    file.group("/fluid");
    if (settings_.particles) file.group("/particles");
  }
  file.close();
  if (settings_.every > 0) on_rank_0([&] { series_ = std::make_unique<XdmfSeries>(stem(settings_.file) + ".xdmf"); });
}

template <class F>
void Output::Impl::on_rank_0(F&& f) const {
  std::string why;
  if (rank_ == 0) {
    try {
      f();
    } catch (const std::exception& e) {
      why = e.what();
    }
  }
  why = from_rank_0(comm_, why);
  if (!why.empty()) throw std::runtime_error(why);
}

void Output::Impl::write_record(Hdf5File& file, const Settings& s, const Record& record) const {
  const std::string at = "/record";
  file.group(at);
  auto say = [&](const std::string& name, const std::string& value) {
    file.attribute(at, name, from_rank_0(comm_, value));
  };
  auto say_all = [&](const std::string& group, const std::vector<std::pair<std::string, std::string>>& pairs) {
    int given = int(pairs.size());
    MPI_Bcast(&given, 1, MPI_INT, 0, comm_);
    for (int i = 0; i < given; ++i) {
      const auto pair = rank_ == 0 ? pairs[i] : std::pair<std::string, std::string>{};
      file.attribute(group, from_rank_0(comm_, pair.first), from_rank_0(comm_, pair.second));
    }
  };
  say("program", "twogrid");
  say("version", TWOGRID_VERSION);
  say("commit", TWOGRID_COMMIT);
  say("compiler", __VERSION__);
  say("HDF5", Hdf5File::library_version());
  say("MPI", mpi_version());
  say_all(at, record.versions);
  say("date", now());
  say("command_line", record.command_line);
  file.text(at + "/input_text", from_rank_0(comm_, record.input_text));

  const int ranks = ranks_of(comm_);
  file.attribute(at, "ranks", std::vector<int>{ranks});
  const auto& cuts = fluid_.layout().cuts();
  file.attribute(at, "bricks",
                 std::vector<int>{int(cuts[0].size()) - 1, int(cuts[1].size()) - 1, int(cuts[2].size()) - 1});
  file.attribute(at, "fine", std::vector<int>(n_.begin(), n_.end()));
  file.attribute(at, "ratio", std::vector<int>(s.ratio.begin(), s.ratio.end()));
  file.attribute(at, "every", std::vector<int>{s.every});
  file.attribute(at, "density", fluid_.density());
  file.attribute(at, "viscosity", fluid_.viscosity());
  file.attribute(at, "drag", s.drag);
  file.attribute(at, "formulation", s.formulation == Formulation::kA ? "A" : "B");
  file.group(at + "/settings");
  say_all(at + "/settings", record.settings);
}

void Output::Impl::write_nodes(Hdf5File& file, const std::string& group, const Grid& grid) const {
  file.group(group);
  std::vector<int> periodic;
  for (int d = 0; d < 3; ++d) {
    const auto nodes = grid.axis[d].nodes();
    file.replicated(group + "/" + kXyz[d], nodes, {nodes.size()}, "m");
    periodic.push_back(grid.axis[d].periodic());
  }
  file.attribute(group, "periodic", periodic);
}

void Output::Impl::frame(double t, long step, const Particles& particles) {
  count_ = {};
  for (int i = 0; i < particles.n; ++i) count_.own += particles.takes_part(i);
  MPI_Exscan(&count_.own, &count_.before, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  if (rank_ == 0) count_.before = 0;
  MPI_Allreduce(&count_.own, &count_.total, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  int has[3] = {count_.own && particles.tag, count_.own && particles.state, count_.own && particles.f};
  MPI_Allreduce(MPI_IN_PLACE, has, 3, MPI_INT, MPI_MAX, comm_);
  count_.has_tag = has[0], count_.has_state = has[1], count_.has_force = has[2];

  char name[16];
  std::snprintf(name, sizeof name, "%06d", frames_);
  const std::string fluid_at = "/fluid/" + std::string(name), particles_at = "/particles/" + std::string(name);

  const double cells = (n_[0] + 1.0) * (n_[1] + 1.0) * (n_[2] + 1.0);
  const double bytes =
      8 * cells * (5 + fluid_.model_fields().size() + (wants("faces") ? 7 : 0)) + 8.0 * 18 * count_.total + 65536;
  const bool has_means = averages_ && averages_->weight() > means_written_;
  Hdf5File file(comm_, settings_.file, Hdf5File::Mode::kAppend, bytes + (has_means ? room_for_means() : 0));
  file.group(fluid_at);
  file.replicated(fluid_at + "/time", {t}, {}, "s");
  file.replicated(fluid_at + "/step", {double(step)}, {});
  write_fluid(file, fluid_at);
  if (wants("faces")) write_faces(file, fluid_at + "/faces");
  if (settings_.particles) {
    file.group(particles_at);
    file.replicated(particles_at + "/time", {t}, {}, "s");
    file.replicated(particles_at + "/step", {double(step)}, {});
    write_particles(file, particles_at, particles);
  }
  if (has_means) write_means(file);
  file.close();
  ++frames_;

  on_rank_0([&] {
    const std::string h5 = name_in_directory(settings_.file);
    std::vector<XdmfField> on_cells, on_points;
    for (const char* f : {"u", "p", "eps"})
      if (wants(f)) on_cells.push_back({f, fluid_at + "/" + f, f[0] == 'u' ? 3 : 1, false});
    for (const ModelField& f : fluid_.model_fields())
      if (wants(f.name)) on_cells.push_back({f.name, fluid_at + "/" + f.name, 1, false});
    std::string grids = xdmf_grid("fluid", h5, "/grid", n_, on_cells);
    if (settings_.particles && count_.total > 0) {
      auto show = [&](const char* f, int components, bool integer = false) {
        on_points.push_back({f, particles_at + "/" + f, components, integer});
      };
      show("velocity", 3), show("radius", 1);
      if (count_.has_tag) show("id", 1, true);
      if (count_.has_force) show("force", 3);
      if (count_.has_state) show("drag", 3), show("pressure_force", 3), show("eps", 1);
      grids += xdmf_points("particles", h5, particles_at + "/position", count_.total, on_points);
    }
    series_->add(t, grids);
  });
  if (has_means) show_means();
}

void Output::Impl::write_fluid(Hdf5File& file, const std::string& at) {
  const auto& p = fluid_.pressure();
  const auto& eps = fluid_.void_fraction();
  if (wants("p")) file.slab(at + "/p", part_of(n_, own_, p.box()), p.data(), "Pa");
  if (wants("eps")) file.slab(at + "/eps", part_of(n_, own_, eps.box()), eps.data(), "1");
  for (const ModelField& f : fluid_.model_fields())
    if (wants(f.name)) file.slab(at + "/" + f.name, part_of(n_, own_, f.values.box()), f.values.data(), f.unit);
  if (!wants("u")) return;
  const auto& u = fluid_.velocity();
  buffer_.resize(3 * own_.count());
  std::size_t m = 0;
  for_each(own_, [&](int i, int j, int k) {
    buffer_[m++] = 0.5 * (u[0](i, j, k) + u[0](i + 1, j, k));
    buffer_[m++] = 0.5 * (u[1](i, j, k) + u[1](i, j + 1, k));
    buffer_[m++] = 0.5 * (u[2](i, j, k) + u[2](i, j, k + 1));
  });
  Slab s = part_of(n_, own_, own_);
  s.memory_extent.clear(), s.memory_offset.clear();
  s.extent.push_back(3), s.offset.push_back(0), s.count.push_back(3);
  file.slab(at + "/u", s, buffer_.data(), "m/s");
}

void Output::Impl::write_faces(Hdf5File& file, const std::string& at) {
  file.group(at);
  const Layout& layout = fluid_.layout();
  auto put = [&](const std::string& name, const Int3& all, const Box& own, const char* unit, auto value) {
    buffer_.resize(own.count());
    std::size_t m = 0;
    for_each(own, [&](int i, int j, int k) { buffer_[m++] = value(i, j, k); });
    file.slab(at + "/" + name, part_of(all, own, own), buffer_.data(), unit);
  };
  auto put_faces = [&](const std::string& name, auto value) {
    for (int d = 0; d < 3; ++d) {
      Int3 all = n_;
      if (!layout.periodic()[d]) ++all[d];
      put(name + kXyz[d], all, layout.faces(d, rank_), "m/s", [&](int i, int j, int k) { return value(d, i, j, k); });
    }
  };
  put_faces("u", [&](int d, int i, int j, int k) { return fluid_.velocity()[d](i, j, k); });
  if (!fluid_.knows_last_step()) return;
  put_faces("flux_", [&](int d, int i, int j, int k) { return fluid_.flux(d, i, j, k); });
  put("deps_dt", n_, own_, "1/s", [&](int i, int j, int k) { return fluid_.void_fraction_rate(i, j, k); });
}

void Output::Impl::write_particles(Hdf5File& file, const std::string& at, const Particles& particles) {
  auto rows = [&](std::size_t components) {
    Slab s;
    s.extent = {std::size_t(count_.total)}, s.offset = {std::size_t(count_.before)},
    s.count = {std::size_t(count_.own)};
    if (components > 1) s.extent.push_back(components), s.offset.push_back(0), s.count.push_back(components);
    return s;
  };
  // value(i, d) of the particles that take part
  auto put = [&](const char* name, int components, const char* unit, auto value) {
    buffer_.clear();
    for (int i = 0; i < particles.n; ++i)
      if (particles.takes_part(i))
        for (int d = 0; d < components; ++d) buffer_.push_back(value(i, d));
    file.slab(at + "/" + name, rows(components), buffer_.data(), unit);
  };
  auto state = [&](int column) {
    return [&particles, column](int i, int d) { return particles.state[i][column + d]; };
  };
  put("position", 3, "m", [&](int i, int d) { return particles.x[i][d]; });
  put("velocity", 3, "m/s", [&](int i, int d) { return particles.v[i][d]; });
  put("radius", 1, "m", [&](int i, int) { return particles.radius[i]; });
  if (count_.has_force) put("force", 3, "N", [&](int i, int d) { return particles.f[i][d]; });
  if (count_.has_state) {
    put("drag", 3, "N", state(kDragForce));
    put("pressure_force", 3, "N", state(kPressureForce));
    put("eps", 1, "1", state(kVoidFraction));
  }
  if (count_.has_tag) {
    std::vector<int> tags;
    for (int i = 0; i < particles.n; ++i)
      if (particles.takes_part(i)) tags.push_back(particles.tag[i]);
    file.slab(at + "/id", rows(1), tags.data());
  }
}

void Output::Impl::average(double weight, const Particles& particles) {
  // Times are sums of steps: a time that differs by round-off from the wanted one counts as that.
  if (averages_ && fluid_.time() >= settings_.average_from * (1 - 1e-12)) averages_->add(weight, fluid_, particles);
}

void Output::Impl::write_means(Hdf5File& file) {
  averages_->write(file);
  file.attribute("/average", "from", settings_.average_from);
  file.attribute("/average", "to", fluid_.time());
  means_written_ = averages_->weight();
}

void Output::Impl::finish() {
  if (!averages_ || averages_->weight() <= means_written_) return;
  Hdf5File file(comm_, settings_.file, Hdf5File::Mode::kAppend, room_for_means());
  write_means(file);
  file.close();
  show_means();
}

// The same datasets from the first time on: the file need not change.
void Output::Impl::show_means() {
  if (means_shown_) return;
  means_shown_ = true;
  on_rank_0([&] {
    auto fields = [](const std::string& at, std::initializer_list<XdmfField> list) {
      std::vector<XdmfField> all(list);
      for (auto& f : all) f.path = at + f.name;
      return all;
    };
    const std::string h5 = name_in_directory(settings_.file);
    write_xdmf(stem(settings_.file) + "_average.xdmf",
               xdmf_grid("fine", h5, "/grid", n_,
                         fields("/average/fine/", {{"eps", "", 1},
                                                   {"p", "", 1},
                                                   {"u", "", 3},
                                                   {"flux", "", 3},
                                                   {"eps_variance", "", 1},
                                                   {"p_variance", "", 1},
                                                   {"u_variance", "", 3}})) +
                   xdmf_grid("particle_grid", h5, "/particle_grid", coarse_.n(),
                             fields("/average/particle_grid/", {{"eps", "", 1},
                                                                {"p", "", 1},
                                                                {"gas_velocity", "", 3},
                                                                {"gas_flux", "", 3},
                                                                {"solids_fraction", "", 1},
                                                                {"solids_velocity", "", 3},
                                                                {"solids_flux", "", 3},
                                                                {"eps_variance", "", 1},
                                                                {"p_variance", "", 1},
                                                                {"gas_velocity_variance", "", 3},
                                                                {"solids_velocity_variance", "", 3}})));
  });
}

Output::Output(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record)
    : impl_(std::make_unique<Impl>(comm, settings, fluid, record)) {}
Output::~Output() = default;
void Output::frame(double t, long step, const Particles& particles) {
  impl_->frame(t, step, particles);
}
void Output::average(double weight, const Particles& particles) {
  impl_->average(weight, particles);
}
void Output::finish() {
  impl_->finish();
}

}  // namespace twogrid
