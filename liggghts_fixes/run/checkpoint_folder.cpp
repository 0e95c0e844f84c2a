#include "liggghts_fixes/run/checkpoint_folder.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "coupling/checkpoint/checksum.h"
#include "coupling/output/on_disk.h"

namespace twogrid {

namespace fs = std::filesystem;

namespace {

constexpr char kRecord[] = "record.txt", kElsewhere[] = "elsewhere.txt", kRemoved[] = "being_removed";

[[noreturn]] void not_written(const std::string& folder, const std::string& why) {
  throw std::runtime_error("a checkpoint can't be written into '" + folder + "' (" + why +
                           "); those that are there are as they were. Make room there, or name another folder "
                           "(fix_modify ID checkpoint folder)");
}

std::string why() {
  return std::strerror(errno);
}

/// Writes and checks all of it. Empty: done; else why not.
std::string written(const std::string& path, const std::string& text) {
  std::FILE* f = std::fopen(path.c_str(), "wb");
  if (!f) return why();
  bool good =
      std::fwrite(text.data(), 1, text.size(), f) == text.size() && std::fflush(f) == 0 && fsync(fileno(f)) == 0;
  std::string failure = good ? "" : why();
  if (std::fclose(f) != 0 && good) failure = why();
  return failure;
}

constexpr long kMostNumber = 1000000000000000;  // the next can be counted

/// -1: no checkpoint's name.
long number_of(const std::string& name) {
  const std::size_t end = name.find("_step_");
  if (end == std::string::npos || end == 0) return -1;
  char* rest = nullptr;
  const long n = std::strtol(name.c_str(), &rest, 10);
  if (rest != name.c_str() + end || n > kMostNumber) return -1;
  std::strtoll(name.c_str() + end + 6, &rest, 10);
  return *rest == '\0' && name.size() > end + 6 ? n : -1;
}

/// Empty: whole; record is filled.
std::string damage(const std::string& path, std::string& record) {
  const std::string text = CheckpointFolder::content(path + "/" + kRecord);
  const std::size_t last = text.rfind("checksum ");
  if (last == std::string::npos || text.substr(last) != "checksum " + text_checksum(text.substr(0, last)) + "\n")
    return "its record is missing or damaged";
  const std::size_t files = text.rfind("\nfiles_of_it ", last);
  if (files == std::string::npos) return "its record is damaged";
  std::istringstream in(text.substr(files + 13, last - files - 13));
  std::size_t n = 0;
  if (!(in >> n)) return "its record is damaged";
  bool particles = false;
  for (std::size_t i = 0; i < n; ++i) {
    std::string name, sum;
    unsigned long long size = 0;
    in >> std::quoted(name) >> size >> sum;
    std::error_code e;
    const auto there = fs::file_size(path + "/" + name, e);
    if (!in || name.empty() || name.find('/') != std::string::npos) return "its record is damaged";
    if (e) return name + " is missing";
    if (there != size) return name + " has " + std::to_string(there) + " bytes in place of " + std::to_string(size);
    try {
      if (file_checksum(path + "/" + name) != sum) return name + " is damaged: its checksum is another";
    } catch (const std::exception& wrong) {
      return wrong.what();
    }
    particles |= name == kParticlesFile;
  }
  if (!particles) return "its record doesn't know the particles' file";
  record = text.substr(0, files + 1);
  return "";
}

Checkpoint newest_of(const std::vector<std::string>& paths) {
  Checkpoint c;
  for (const std::string& p : paths) {
    const std::string wrong = damage(p, c.record);
    if (wrong.empty()) {
      c.path = p;
      break;
    }
    c.passed_over.push_back("the checkpoint " + p + " is not used: " + wrong);
  }
  return c;
}

std::vector<std::string> paths_in(const std::string& folder) {
  std::vector<std::string> paths;
  for (const std::string& n : CheckpointFolder(folder).names()) paths.push_back(folder + "/" + n);
  return paths;
}

}  // namespace

std::string default_folder(const std::string& script) {
  return fs::path(script).filename().string() + ".checkpoints";
}

std::vector<std::string> CheckpointFolder::names() const {
  std::vector<std::string> found;
  std::error_code e;
  for (fs::directory_iterator it(path_, e), end; !e && it != end; it.increment(e))
    if (const std::string name = it->path().filename().string(); number_of(name) >= 0) found.push_back(name);
  std::sort(found.begin(), found.end(),
            [](const std::string& a, const std::string& b) { return number_of(a) > number_of(b); });
  return found;
}

std::string CheckpointFolder::begin(double bytes) const {
  std::error_code e;
  fs::create_directories(path_, e);
  if (e) not_written(path_, e.message());
  give_up();
  fs::create_directory(part(), e);
  if (e) not_written(path_, e.message());
  // Room for it, as far as it can be known.
  const std::string reserve = part() + "/room";
  const int f = open(reserve.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0644);
  int failure = f < 0 ? errno : 0;
  if (f >= 0) {
    failure = posix_fallocate(f, 0, off_t(bytes));
    if (failure == EOPNOTSUPP || failure == EINVAL) failure = 0;
    close(f);
    std::remove(reserve.c_str());
  }
  if (failure != 0) {
    give_up();
    not_written(path_, std::strerror(failure));
  }
  return part();
}

std::string CheckpointFolder::content(const std::string& file) {
  std::error_code e;
  if (!fs::is_regular_file(file, e)) return "";  // others may have no end
  std::ifstream in(file, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
}

double CheckpointFolder::size(const std::string& path) {
  double bytes = 0;
  std::error_code e;
  for (fs::directory_iterator it(path, e), end; !e && it != end; it.increment(e)) bytes += double(it->file_size(e));
  return bytes;
}

void CheckpointFolder::add(const std::string& name, const std::string& text) const {
  const std::string failure = written(part() + "/" + name, text);
  if (!failure.empty()) not_written(path_, failure);
}

void CheckpointFolder::give_up() const {
  std::error_code e;
  fs::remove_all(path_ + "/" + kRemoved, e);
  fs::remove_all(part(), e);
}

std::string CheckpointFolder::complete(const ResumePoint& point, int keep, long above) const {
  std::vector<std::string> before = names();
  std::ostringstream manifest;
  std::vector<std::string> files;
  std::error_code e;
  for (fs::directory_iterator it(part(), e), end; !e && it != end; it.increment(e))
    files.push_back(it->path().filename().string());
  std::sort(files.begin(), files.end());
  manifest << "\nfiles_of_it " << files.size() << '\n';
  std::string failure = e ? e.message() : "";
  for (const std::string& name : files) {
    const std::string file = part() + "/" + name;
    if (failure.empty()) failure = sync_to_disk(file);
    manifest << std::quoted(name) << ' ' << fs::file_size(file, e) << ' ' << file_checksum(file) << '\n';
  }
  std::string text = to_text(point) + manifest.str();
  text += "checksum " + text_checksum(text) + "\n";
  // LIGGGHTS doesn't look whether its restart file could be written: where the disk is full now, it could not.
  if (failure.empty()) failure = written(part() + "/probe", std::string(65536, 'x'));
  std::remove((part() + "/probe").c_str());
  if (failure.empty()) failure = written(part() + "/" + kRecord, text);
  const long last = std::max(above, before.empty() ? 0 : number_of(before.front()));
  char name[64];
  std::snprintf(name, sizeof name, "%06ld_step_%lld", last + 1, point.step);
  std::string path = path_ + "/" + name;
  if (failure.empty()) failure = put_in_place(part(), path);
  if (!failure.empty()) {
    give_up();
    not_written(path_, failure);
  }
  // Under another name first: what a killed process has half removed is no checkpoint.
  for (std::size_t i = std::size_t(std::max(keep, 1)) - 1; i < before.size(); ++i) {
    fs::rename(path_ + "/" + before[i], path_ + "/" + kRemoved, e);
    fs::remove_all(path_ + "/" + kRemoved, e);
  }
  return path;
}

Checkpoint find_checkpoint(const std::string& path) {
  std::error_code e;
  if (fs::exists(path + "/" + kRecord, e)) return newest_of({path});
  return newest_of(paths_in(path));
}

/// In all folders of the script, the newest first.
static std::vector<std::string> paths_of(const std::string& script) {
  const std::string folder = default_folder(script);
  std::vector<std::string> paths = paths_in(folder);
  std::istringstream in(CheckpointFolder::content(folder + "/" + kElsewhere));
  for (std::string other; std::getline(in, other);)
    for (const std::string& p : paths_in(other)) paths.push_back(p);
  const auto number = [](const std::string& p) { return number_of(fs::path(p).filename().string()); };
  std::stable_sort(paths.begin(), paths.end(),
                   [&](const std::string& a, const std::string& b) { return number(a) > number(b); });
  return paths;
}

Checkpoint find_checkpoint_of(const std::string& script) {
  return newest_of(paths_of(script));
}

long last_number(const std::string& script) {
  const std::vector<std::string> paths = paths_of(script);
  return paths.empty() ? 0 : number_of(fs::path(paths.front()).filename().string());
}

void note_folder(const std::string& script, const std::string& folder) {
  const std::string own = default_folder(script);
  if (folder == own) return;
  std::error_code e;
  fs::create_directories(own, e);
  std::istringstream in(CheckpointFolder::content(own + "/" + kElsewhere));
  for (std::string known; std::getline(in, known);)
    if (known == folder) return;
  std::ofstream(own + "/" + kElsewhere, std::ios::app) << folder << "\n";
}

}  // namespace twogrid
