#include "coupling/output/output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/rank_0.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/file_lock.h"
#include "coupling/output/frame_writer.h"
#include "coupling/output/growing_file.h"
#include "coupling/output/means.h"
#include "coupling/output/on_disk.h"
#include "coupling/output/record.h"
#include "coupling/output/run_files.h"
#include "coupling/output/wall_writer.h"
#include "coupling/output/xdmf.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

namespace {

constexpr std::size_t kNames = 32768;  // room for the names of 4000 frames

void check_fields(const std::vector<std::string>& wanted, const Fluid& fluid) {
  std::vector<std::string> known = output_fields();
  for (const ModelField& f : fluid.model_fields()) known.push_back(f.name);
  std::string list;
  for (const auto& f : known) list += (list.empty() ? "" : ", ") + f;
  for (const auto& f : wanted)
    if (std::find(known.begin(), known.end(), f) == known.end())
      throw std::invalid_argument("output fields: '" + f + "' is no field that can be written; give some of " + list);
}

OutputSettings with_default_fields(OutputSettings s, const Fluid& fluid) {
  check(s);
  check_fields(s.fields, fluid);
  const auto wants = [&](const char* f) { return std::find(s.fields.begin(), s.fields.end(), f) != s.fields.end(); };
  if (s.fields.empty()) {
    s.fields = {"u", "p", "eps"};
    for (const ModelField& f : fluid.model_fields()) s.fields.push_back(f.name);
  }
  if (wants("walls") && !fluid.wall_stress())
    throw std::invalid_argument(
        "output fields: found 'walls', the stress on the surfaces of bodies, in a fluid without bodies; wanted: "
        "'solid' "
        "(fix_modify ID solid NAME mesh FIXID), or 'walls' left out");
  if (wants("faces") && !wants("eps")) s.fields.push_back("eps");
  return s;
}

}  // namespace

const std::vector<std::string>& output_fields() {
  static const std::vector<std::string> kFields{"u", "p", "eps", "faces", "walls"};
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
  std::vector<std::string> begin(long step, long last);
  void frame(double t, long step, const Particles& particles);
  void finish();
  std::string sync();
  OutputState& state() { return state_; }
  Means& means() { return means_; }
  WallMeansState* wall_means() { return walls_.has_means() ? &walls_.state() : nullptr; }

 private:
  std::string id() const;
  void lock();
  std::vector<std::string> begin_locked(long step, long last);
  void create(const WhereToWrite& where, long step);
  void go_on(const WhereToWrite& where, long step);
  void write_means(GrowingFile& file);
  void show_means();
  /// Written over, once they are in the file.
  double room_for_means() const { return means_in_file_ ? 0 : means_.bytes() + walls_.bytes_of_means(); }
  void make_groups(GrowingFile& file) const;

  MPI_Comm comm_;
  int rank_ = 0;
  const Fluid& fluid_;
  Settings all_settings_;
  OutputSettings settings_;
  Record record_;
  ParticleGrid coarse_;
  Int3 n_;
  OutputState state_;
  bool begun_ = false;
  FileLock lock_;     // rank 0 only
  std::string file_;  // that of this leg
  int frames_ = 0;    // in it
  bool means_in_file_ = false;
  bool means_shown_ = false;  // their XDMF file is there

  FrameWriter frame_writer_;
  WallWriter walls_;
  Means means_;
  std::unique_ptr<XdmfSeries> series_;  // rank 0 only
};

Output::Impl::Impl(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record)
    : comm_(comm),
      rank_(rank_of(comm)),
      fluid_(fluid),
      all_settings_(settings),
      settings_(with_default_fields(settings.output, fluid)),
      record_(record),
      coarse_(fluid.grid(), settings.ratio),
      n_(fluid.grid().n()),
      file_(settings_.file),
      frame_writer_(comm, fluid, settings_),
      walls_(comm, fluid, settings),
      means_(comm, fluid, settings_, walls_) {
  coarse_.take_open_part(comm, fluid, {1, 1, 1});
  means_.begin(coarse_);
}

std::string Output::Impl::id() const {
  char text[32];
  std::snprintf(text, sizeof text, "%08x%08x", unsigned(state_.run_high), unsigned(state_.run_low));
  return text;
}

void Output::Impl::lock() {
  on_rank_0(comm_, [&] {
    const std::string real = real_path(settings_.file);
    if (!lock_.take(real))
      throw std::runtime_error("output file: found that '" + settings_.file + "' is being written by another run (" +
                               lock_.who() +
                               "), wanted a file of its own for each: wait for its end, or give another name");
  });
}

std::vector<std::string> Output::Impl::begin(long step, long last) {
  if (begun_) return {};
  lock();
  try {
    return begin_locked(step, last);
  } catch (...) {
    lock_.release();
    throw;
  }
}

std::vector<std::string> Output::Impl::begin_locked(long step, long last) {
  WhereToWrite where;
  const bool goes_on = state_.run_high != 0 || state_.run_low != 0;
  on_rank_0(comm_, [&] {
    where = goes_on ? go_on_with_files(settings_, id(), n_, all_settings_.ratio, double(last)) : begin_files(settings_);
  });
  file_ = from_rank(comm_, 0, where.file);
  int said[5] = {where.create, where.frames, where.means, where.leg, int(where.drop.size())};
  MPI_Bcast(said, 5, MPI_INT, 0, comm_);
  where.create = said[0], where.frames = said[1], where.means = said[2], where.leg = said[3];
  if (!goes_on) {
    double bits[2] = {0, 0};
    std::random_device random;
    while (bits[0] == 0 && bits[1] == 0)
      bits[0] = double(random() & 0xffffffffu), bits[1] = double(random() & 0xffffffffu);
    MPI_Bcast(bits, 2, MPI_DOUBLE, 0, comm_);
    state_.run_high = bits[0], state_.run_low = bits[1];
  }
  if (where.create)
    create(where, step);
  else
    go_on(where, step);
  if (settings_.every > 0)
    on_rank_0(comm_, [&] { series_ = std::make_unique<XdmfSeries>(stem(settings_.file) + ".xdmf", where.shown); });
  begun_ = true;
  return where.sentences;
}

/// Beside the file of that name, and put in its place when it is whole.
void Output::Impl::create(const WhereToWrite& where, long step) {
  const std::string real = from_rank(comm_, 0, rank_ == 0 ? real_path(file_) : ""), part = real + ".part";
  const auto remove_part = [&] {
    if (rank_ == 0) std::remove(part.c_str());
  };
  try {
    GrowingFile file(
        comm_, part, true,
        bytes_of_record(record_, fluid_) + frame_writer_.bytes_of_open_shares(coarse_) + walls_.bytes_of_bodies());
    write_record(file, comm_, all_settings_, fluid_, coarse_, record_, id());
    frame_writer_.write_open_shares(file, coarse_);
    walls_.write_bodies(file);
    if (where.leg > 0) write_leg(file, comm_, record_, where.leg, step);
    make_groups(file);
    file.close();
    on_rank_0(comm_, [&] {
      if (std::rename(part.c_str(), real.c_str()) != 0)
        throw std::runtime_error("the file '" + real +
                                 "' could not be put in place; give another path (fix_modify ID output file)");
    });
  } catch (...) {
    remove_part();
    throw;
  }
}

void Output::Impl::make_groups(GrowingFile& file) const {
  if (settings_.every <= 0) return;
  file.group("/fluid", kNames);
  if (settings_.particles) file.group("/particles", kNames);
  if (walls_.has_surfaces()) file.group("/walls", kNames);
}

void Output::Impl::go_on(const WhereToWrite& where, long step) {
  frames_ = where.frames;
  {
    // By itself, so that what follows does not lie where a frame was that the file still names.
    GrowingFile file(comm_, file_, false, 65536);
    for (const std::string& name : where.drop)
      file.remove("/fluid/" + name), file.remove("/particles/" + name), file.remove("/walls/" + name);
    file.close();
  }
  const bool has_means = means_.there();
  means_in_file_ = where.means && has_means;
  GrowingFile file(comm_, file_, false, 262144 + walls_.bytes_of_bodies() + (has_means ? room_for_means() : 0));
  write_leg(file, comm_, record_, where.leg, step);
  make_groups(file);
  walls_.write_bodies(file);
  // Those of the checkpoint, not later ones.
  if (where.means && !has_means) file.remove("/average");
  if (has_means) write_means(file);
  file.close();
  if (has_means) show_means();
}

void Output::Impl::frame(double t, long step, const Particles& particles) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d", frames_);
  const double bytes = frame_writer_.count(particles) + walls_.bytes_of_frame();
  const bool has_means = means_.are_new();
  GrowingFile file(comm_, file_, false, bytes + (has_means ? room_for_means() : 0));
  XdmfFrame shown = frame_writer_.write(file, name, t, step, particles);
  shown.walls = walls_.write_frame(file, name, t, step);
  if (has_means) write_means(file);
  file.close();
  ++frames_;
  shown.h5 = name_in_directory(file_);
  on_rank_0(comm_, [&] { series_->add(shown); });
  if (has_means) show_means();
}

void Output::Impl::write_means(GrowingFile& file) {
  means_.write(file);
  walls_.write_means(file);
  means_in_file_ = true;
}

void Output::Impl::finish() {
  if (!means_.are_new()) return;
  GrowingFile file(comm_, file_, false, room_for_means());
  write_means(file);
  file.close();
  show_means();
}

std::string Output::Impl::sync() {
  std::string why = begun_ && rank_ == 0 ? sync_to_disk(file_) : "";
  if (!why.empty())
    why = "output file: '" + file_ + "' could not be brought to the disk (" + why +
          "): its last frames may be lost if the machine fails; see whether the disk is full or gone";
  return from_rank(comm_, 0, why);
}

// The same datasets from the first time on: the file need not change.
void Output::Impl::show_means() {
  if (means_shown_) return;
  means_shown_ = true;
  on_rank_0(comm_, [&] {
    auto fields = [&](const std::string& at, std::initializer_list<XdmfField> list) {
      std::vector<XdmfField> all(list);
      for (auto& f : all) f.path = at + f.name;
      if (fluid_.open_shares())
        for (const XdmfField& f : open_fields(at == "/average/fine/" ? "/grid" : "/particle_grid")) all.push_back(f);
      return all;
    };
    const std::string h5 = name_in_directory(file_);
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
                                                                {"solids_velocity_variance", "", 3}})) +
                   (walls_.has_means() ? xdmf_surface(h5, walls_.shown(), "/average/walls/") : ""));
  });
}

Output::Output(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record)
    : impl_(std::make_unique<Impl>(comm, settings, fluid, record)) {}
Output::~Output() = default;
std::vector<std::string> Output::begin(long step, long last) {
  return impl_->begin(step, last);
}
void Output::frame(double t, long step, const Particles& particles) {
  impl_->frame(t, step, particles);
}
std::string Output::average(double weight, const Particles& particles, double pressure_drop) {
  return impl_->means().add(weight, particles, pressure_drop);
}
bool Output::sure_enough() const {
  return impl_->means().sure_enough();
}
long long Output::samples_to_decide() const {
  return impl_->means().samples_to_decide();
}
std::string Output::sureness() const {
  return impl_->means().sureness();
}
double& Output::means_anew() {
  return impl_->means().anew();
}
void Output::set_driven(bool driven) {
  impl_->means().set_driven(driven);
}
void Output::average_as(const OutputSettings& settings) {
  impl_->means().average_as(settings);
}
std::string Output::meet_other_conditions(const std::string& what, bool* warns) {
  return impl_->means().meet_other_conditions(what, warns);
}
void Output::finish() {
  impl_->finish();
}
std::string Output::sync() {
  return impl_->sync();
}
OutputState& Output::state() {
  return impl_->state();
}
WallMeansState* Output::wall_means() {
  return impl_->wall_means();
}
StartUp* Output::start_up() {
  return impl_->means().start_up();
}
Averages* Output::averages() {
  return impl_->means().averages();
}

}  // namespace twogrid
