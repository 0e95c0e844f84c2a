#include "liggghts_fixes/run/planned_files.h"

#include <atom.h>
#include <atom_vec.h>
#include <dump.h>
#include <lammps.h>
#include <modify.h>
#include <mpi.h>
#include <output.h>
#include <update.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <utility>

#include "cfd/parallel/rank_0.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/run/checkpoint_folder.h"
#include "liggghts_fixes/run/still_files.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

struct Inside : Dump {
  static std::string file(Dump& d) { return d.*&Inside::filename; }
};

/// Multiples of `every` in (from, to].
double multiples(long long from, long long to, long long every) {
  if (every <= 0) return 0;
  const long long before = from / every, all = to / every;
  return double(all - before);
}

/// What a dump has written so far, of all ranks: in one file, or in one for each step, or rank.
double bytes_of(const std::string& name) {
  const std::size_t at = name.find_first_of("*%");
  if (at == std::string::npos) return still_bytes(name);
  double bytes = 0;
  for (const StillFile& f : still_files())
    if (f.path.compare(0, at, name, 0, at) == 0) bytes += f.bytes;
  return bytes;
}

double sum(double value, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, comm);
  return value;
}

}  // namespace

PlannedFiles::Kind& PlannedFiles::kind(const std::string& name, const std::string& what) {
  Kind& k = kinds_[name];
  k.what = what;
  return k;
}

void PlannedFiles::ask_dumps() {
  LAMMPS_NS::Output& output = *lammps_.output;
  const bigint last = lammps_.update->ntimestep + 1;
  bool asked = false;
  for (int i = 0; i < output.ndump; ++i) {
    const std::string name = Inside::file(*output.dump[i]);
    before_[name] = sum(bytes_of(name), lammps_.world);
    if (kinds_.count(name)) {
      output.next_dump[i] = last + 1;  // enough
      continue;
    }
    output.next_dump[i] = last;
    asked = true;
  }
  if (output.ndump > 0) output.next_dump_any = asked ? last : last + 1;
  if (asked) lammps_.modify->addstep_compute_all(last);
}

void PlannedFiles::measure_dumps() {
  const LAMMPS_NS::Output& output = *lammps_.output;
  for (int i = 0; i < output.ndump; ++i) {
    const std::string name = Inside::file(*output.dump[i]);
    const auto before = before_.find(name);
    const double piece = before == before_.end() ? 0.0 : sum(bytes_of(name), lammps_.world) - before->second;
    if (piece > 0) kind(name, "frames").piece = piece;
  }
}

void PlannedFiles::count(long long from, long long to, const std::vector<Command>& commands) {
  count_frames(from, to);
  count_dumps(from, to);
  count_restarts(from, to, commands);
  count_tables(from, to, commands);
  count_log(from, to, commands);
  count_checkpoints();
}

void PlannedFiles::count_frames(long long from, long long to) {
  for (int i = 0; i < lammps_.modify->nfix; ++i) {
    auto* f = dynamic_cast<FixTwogrid*>(lammps_.modify->fix[i]);
    if (!f) continue;
    const OutputSettings& out = f->settings().output;
    const PlannedOutput cost = f->measure_output();
    if (cost.empty <= 0) continue;
    Kind& k = kind(out.file, "frames" + std::string(out.average_from >= 0 ? ", and means" : ""));
    k.begin = cost.empty + cost.means, k.piece = cost.bytes;
    if (out.every <= 0) continue;
    // The fluid's first frame is of the run's beginning, unless it goes on from a checkpoint.
    const bool is_first = next_frame_.try_emplace(out.file, 0).second && f->next_frame() <= from;
    const double frames = multiples(from, to, out.every) + (is_first ? 1 : 0);
    k.pieces += frames;
    f->pass_frames(to);
    seconds_ += frames * cost.seconds;
  }
}

double PlannedFiles::take_seconds() {
  return std::exchange(seconds_, 0.0);
}

void PlannedFiles::count_dumps(long long from, long long to) {
  const LAMMPS_NS::Output& output = *lammps_.output;
  for (int i = 0; i < output.ndump; ++i) {
    const std::string name = Inside::file(*output.dump[i]);
    Kind& k = kind(name, "frames");
    const bool first =
        k.pieces == 0 && (output.dump[i]->first_flag || (output.every_dump[i] > 0 && from % output.every_dump[i] == 0));
    k.pieces += multiples(from, to, output.every_dump[i]) + (first ? 1 : 0);
  }
}

/// restart 0, restart N FILE, restart N FILE FILE
void PlannedFiles::count_restarts(long long from, long long to, const std::vector<Command>& commands) {
  const auto last = std::find_if(commands.rbegin(), commands.rend(),
                                 [](const Command& c) { return c[0] == "restart" && c.size() > 1; });
  if (last == commands.rend() || last->size() < 3) return;
  const double times = multiples(from, to, std::atoll((*last)[1].c_str()));
  const double bytes = sum(8.0 * lammps_.atom->avec->size_restart(), lammps_.world);
  for (std::size_t i = 2; i < last->size() && times > 0; ++i) {
    Kind& k = kind((*last)[i], last->size() == 3 ? "restart files" : "restart file");
    k.piece = bytes, k.pieces = last->size() == 3 ? k.pieces + times : 1;
  }
}

/// fix ave/... and fix print with a file: lines of some 9 characters a value.
void PlannedFiles::count_tables(long long from, long long to, const std::vector<Command>& commands) {
  static const std::set<std::string> kKeywords{"file",   "mode",   "ave",    "start",  "off",    "overwrite",
                                               "title1", "title2", "title3", "append", "screen", "title"};
  for (const Command& c : commands) {
    if (c.size() < 6 || c[0] != "fix" || lammps_.modify->find_fix(c[1].c_str()) < 0) continue;
    const bool prints = c[3] == "print";
    if (!prints && c[3].rfind("ave/time", 0) != 0) continue;
    const auto file =
        std::find_if(c.begin() + 4, c.end(), [](const std::string& w) { return w == "file" || w == "append"; });
    if (file == c.end() || file + 1 == c.end()) continue;
    const long long every = std::atoll(c[prints ? 4 : std::min<std::size_t>(6, c.size() - 1)].c_str());
    double line = 9;
    if (prints) line = 2.0 * double(c[5].size());
    for (std::size_t i = 7; !prints && i < c.size() && !kKeywords.count(c[i]); ++i) line += 8.5;
    Kind& k = kind(*(file + 1), "lines");
    k.piece = line, k.pieces += multiples(from, to, every);
  }
}

/// Those that the script asks for, as many as are kept; once it has been seen how large one is.
void PlannedFiles::count_checkpoints() {
  for (int i = 0; i < lammps_.modify->nfix; ++i) {
    auto* f = dynamic_cast<FixTwogrid*>(lammps_.modify->fix[i]);
    if (!f || !f->has_state() || !f->checkpoint_plan().by_itself()) continue;
    const CheckpointPlan& plan = f->checkpoint_plan();
    Kind& k = kind(plan.folder.empty() ? default_folder(script_) : plan.folder, "checkpoints at most");
    if (k.piece > 0) continue;
    const std::string name = std::string(f->id) + ".h5 of a checkpoint";
    f->write_checkpoint(from_rank(lammps_.world, 0, still_path(name)));
    k.piece = sum(still_bytes(name) + 8.0 * lammps_.atom->avec->size_restart(), lammps_.world);
    k.pieces = plan.keep;
    forget_still_file(name);
  }
}

/// Thermo lines of some 14 characters a column.
void PlannedFiles::count_log(long long from, long long to, const std::vector<Command>& commands) {
  double columns = 5;
  long long every = 0;
  for (const Command& c : commands) {
    if (c[0] == "thermo_style" && c.size() > 2 && c[1] == "custom") columns = double(c.size()) - 2;
    if (c[0] == "thermo" && c.size() > 1) every = std::atoll(c[1].c_str());
  }
  Kind& k = kind("log.liggghts", "lines of thermo output");
  k.begin = 8000;
  const double lines = 2 + multiples(from, to, every);
  k.piece = (k.pieces * k.piece + lines * 14 * columns) / (k.pieces + lines);
  k.pieces += lines;
}

std::vector<PlannedFile> PlannedFiles::list() const {
  std::vector<PlannedFile> files;
  std::set<std::string> known;
  for (const auto& [name, k] : kinds_) {
    char number[32];
    std::snprintf(number, sizeof number, "%.0f ", k.pieces);
    if (k.begin + k.pieces * k.piece <= 0) continue;
    files.push_back({name, k.begin + k.pieces * k.piece, number + k.what});
  }
  for (const StillFile& f : still_files()) {
    bool of_kind = false;
    for (const auto& entry : kinds_) {
      const std::size_t at = entry.first.find_first_of("*%");
      of_kind = of_kind || f.path == entry.first ||
                (at != std::string::npos && f.path.compare(0, at, entry.first, 0, at) == 0);
    }
    if (!of_kind && f.bytes > 0) files.push_back({f.path, f.bytes, ""});
  }
  std::sort(files.begin(), files.end(), [](const PlannedFile& a, const PlannedFile& b) { return a.bytes > b.bytes; });
  return files;
}

}  // namespace twogrid
