#include "coupling/output/frame_writer.h"

#include <algorithm>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/growing_file.h"
#include "coupling/two_grid/open_nodes.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

namespace {

const char* const kXyz[3] = {"x", "y", "z"};

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

FrameWriter::FrameWriter(MPI_Comm comm, const Fluid& fluid, const OutputSettings& settings)
    : comm_(comm),
      rank_(rank_of(comm)),
      fluid_(fluid),
      settings_(settings),
      n_(fluid.grid().n()),
      own_(fluid.layout().cells(rank_)) {}

bool FrameWriter::wants(const std::string& field) const {
  return std::find(settings_.fields.begin(), settings_.fields.end(), field) != settings_.fields.end();
}

double FrameWriter::count(const Particles& particles) {
  count_ = {};
  for (int i = 0; i < particles.n; ++i) count_.own += particles.takes_part(i);
  MPI_Exscan(&count_.own, &count_.before, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  if (rank_ == 0) count_.before = 0;
  MPI_Allreduce(&count_.own, &count_.total, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  int has[3] = {count_.own && particles.tag, count_.own && particles.state, count_.own && particles.f};
  MPI_Allreduce(MPI_IN_PLACE, has, 3, MPI_INT, MPI_MAX, comm_);
  count_.has_tag = has[0], count_.has_state = has[1], count_.has_force = has[2];
  const double cells = (n_[0] + 1.0) * (n_[1] + 1.0) * (n_[2] + 1.0);
  return 8 * cells * (5 + fluid_.model_fields().size() + (wants("faces") ? 7 : 0)) + 8.0 * 18 * count_.total + 65536;
}

double FrameWriter::bytes_of_open_shares(const ParticleGrid& nodes) const {
  return fluid_.open_shares() ? 12 * double(fluid_.grid().cells().count() + nodes.cells().count()) + 16384 : 0;
}

void FrameWriter::write_open_shares(GrowingFile& file, const ParticleGrid& nodes) {
  if (!fluid_.open_shares()) return;
  constexpr int kHidden = 32;  // HIDDENCELL of VTK's ghost cells
  const auto put = [&](const std::string& grid, const Int3& all, const Box& own, auto share) {
    buffer_.clear();
    std::vector<int> blank;
    for_each(own, [&](int i, int j, int k) {
      buffer_.push_back(share(i, j, k));
      blank.push_back(buffer_.back() > 0 ? 0 : kHidden);
    });
    const Slab slab = part_of(all, own, own);
    file.slab(grid + "/theta", slab, buffer_.data(), "1");
    file.slab(grid + "/blank", slab, blank.data());
  };
  put("/grid", n_, own_, [&](int i, int j, int k) { return fluid_.open_shares()->theta()(i, j, k); });
  put("/particle_grid", nodes.n(), node_layout(fluid_.layout(), nodes).cells(rank_),
      [&](int i, int j, int k) { return nodes.open_nodes()->open_part()(i, j, k) / nodes.Grid::volume(i, j, k); });
}

XdmfFrame FrameWriter::write(GrowingFile& file, const std::string& name, double t, long step,
                             const Particles& particles) {
  const std::string fluid_at = "/fluid/" + name, particles_at = "/particles/" + name;
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

  XdmfFrame shown;
  shown.name = name, shown.time = t, shown.step = step, shown.n = n_;
  for (const char* f : {"u", "p", "eps"})
    if (wants(f)) shown.cells.push_back({f, "", f[0] == 'u' ? 3 : 1, false});
  for (const ModelField& f : fluid_.model_fields())
    if (wants(f.name)) shown.cells.push_back({f.name, "", 1, false});
  if (fluid_.open_shares())
    for (const XdmfField& f : open_fields("/grid")) shown.cells.push_back(f);
  if (settings_.particles && count_.total > 0) {
    shown.particles = count_.total;
    auto show = [&](const char* f, int components, bool integer = false) {
      shown.points.push_back({f, "", components, integer});
    };
    show("velocity", 3), show("radius", 1);
    if (count_.has_tag) show("id", 1, true);
    if (count_.has_force) show("force", 3);
    if (count_.has_state) show("drag", 3), show("pressure_force", 3), show("eps", 1);
  }
  return shown;
}

void FrameWriter::write_fluid(GrowingFile& file, const std::string& at) {
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

void FrameWriter::write_faces(GrowingFile& file, const std::string& at) {
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

void FrameWriter::write_particles(GrowingFile& file, const std::string& at, const Particles& particles) {
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

}  // namespace twogrid
