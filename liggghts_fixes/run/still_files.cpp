#include "liggghts_fixes/run/still_files.h"

#include <dlfcn.h>
#include <ftw.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>

namespace twogrid {
namespace {

struct Still {
  bool on = false, any_folder = false;
  std::string folder;                        // empty: not made yet
  std::map<std::string, std::string> files;  // absolute name, name in the folder
  std::map<std::string, std::string> names;  // absolute name, name as it was given
  std::set<std::string> folders;             // made since
};

/// Of static duration, and never destroyed: files are closed after everything else.
Still& still() {
  static Still* const kStill = new Still;
  return *kStill;
}

std::string absolute(const std::string& path) {
  std::string whole = path;
  if (path.empty() || path[0] != '/') {
    char here[4096];
    if (getcwd(here, sizeof here)) whole = std::string(here) + "/" + path;
  }
  std::string clean;
  for (std::size_t at = 0; at < whole.size();) {
    const std::size_t end = std::min(whole.find('/', at), whole.size());
    const std::string part = whole.substr(at, end - at);
    if (part == "..")
      clean.erase(clean.empty() ? 0 : clean.rfind('/'));
    else if (!part.empty() && part != ".")
      clean += "/" + part;
    at = end + 1;
  }
  return clean.empty() ? "/" : clean;
}

bool begins_with(const std::string& s, const std::string& beginning) {
  return s.compare(0, beginning.size(), beginning) == 0;
}

/// What isn't the user's: devices, and the folder itself.
bool passes(const std::string& whole) {
  const Still& s = still();
  return begins_with(whole, "/dev/") || begins_with(whole, "/proc/") || begins_with(whole, "/sys/") ||
         (!s.folder.empty() && begins_with(whole, s.folder + "/"));
}

template <class F>
F* original(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}

/// However the process ends, also by a signal that it doesn't see: a shell reads from it until then. A launcher that ends
/// all of a group of processes doesn't reach it.
void remove_after_process(const std::string& folder) {
  setenv("TWOGRID_PLAN_FOLDER", folder.c_str(), 1);
  static auto* const real = original<FILE*(const char*, const char*)>("popen");
  real(
      "exec >/dev/null 2>&1; s='cat; rm -rf -- \"$TWOGRID_PLAN_FOLDER\"'; if command -v setsid; then exec setsid sh -c "
      "\"$s\"; "
      "else trap '' INT TERM HUP; eval \"$s\"; fi",
      "w");
}

const std::string& folder() {
  Still& s = still();
  if (s.folder.empty()) {
    const char* const place = std::getenv("TMPDIR");
    std::string name = absolute(std::string(place && *place ? place : "/tmp") + "/twogrid_plan_XXXXXX");
    if (!mkdtemp(name.data()))
      throw std::runtime_error("-plan: no folder could be made in " + name.substr(0, name.rfind('/')) +
                               "; wanted one for files of the moment (TMPDIR)");
    s.folder = name;
    remove_after_process(name);
  }
  return s.folder;
}

/// Whether a file of that name could be written there.
bool may_be_written(const std::string& whole) {
  const Still& s = still();
  if (s.any_folder || s.files.count(whole)) return true;
  const std::string in = whole.substr(0, std::max<std::size_t>(1, whole.rfind('/')));
  if (s.folders.count(in)) return true;
  struct stat found;
  if (stat(whole.c_str(), &found) == 0) {
    if (S_ISDIR(found.st_mode)) return errno = EISDIR, false;
    return access(whole.c_str(), W_OK) == 0;
  }
  return access(in.c_str(), W_OK) == 0;
}

std::string written_to(const std::string& whole, const std::string& path) {
  Still& s = still();
  const auto [at, is_new] = s.files.try_emplace(whole);
  if (is_new) {
    const std::string name = whole.substr(whole.rfind('/') + 1);
    at->second =
        folder() + "/" + std::to_string(s.files.size()) + "_" + name.substr(name.size() > 200 ? name.size() - 200 : 0);
    s.names[whole] = path;
  }
  return at->second;
}

int remove_entry(const char* path, const struct stat*, int, FTW*) {
  return std::remove(path);
}

using Open = FILE*(const char*, const char*);

UnopenedFile& unopened() {
  static UnopenedFile* const kUnopened = new UnopenedFile;  // as still()
  return *kUnopened;
}

/// Notes why a file can't be opened to be written.
FILE* open_noted(Open* real, const char* path, const char* mode, const std::string& there) {
  FILE* const file = real(there.c_str(), mode);
  if (!file && std::strpbrk(mode, "wa+")) unopened() = {path, errno};
  return file;
}

FILE* open_still(Open* real, const char* path, const char* mode) {
  if (!path || !mode) return real(path, mode);
  if (!still().on) return open_noted(real, path, mode, path);
  const std::string whole = absolute(path);
  if (passes(whole)) return real(path, mode);
  if (!std::strpbrk(mode, "wa+")) return real(still_path_to_read(path).c_str(), mode);
  if (!may_be_written(whole)) {
    unopened() = {path, errno};
    return nullptr;
  }
  const std::string there = written_to(whole, path);
  return real(there.c_str(), mode[0] == 'r' ? "w+" : mode);
}

}  // namespace

void keep_files_still() {
  still().on = true;
  std::atexit(forget_still_files);
}

bool files_are_still() {
  return still().on;
}

std::string still_path(const std::string& path) {
  return still().on ? written_to(absolute(path), path) : path;
}

std::string still_path_to_read(const std::string& path) {
  if (!still().on) return path;
  const auto found = still().files.find(absolute(path));
  return found == still().files.end() ? path : found->second;
}

bool can_be_written(const std::string& path) {
  return may_be_written(absolute(path));
}

double still_bytes(const std::string& path) {
  struct stat found;
  return stat(still_path_to_read(path).c_str(), &found) == 0 ? double(found.st_size) : 0.0;
}

void forget_still_file(const std::string& path) {
  const auto found = still().files.find(absolute(path));
  if (found == still().files.end()) return;
  std::remove(found->second.c_str());
  still().files.erase(found);
}

void take_as_folder(const std::string& path) {
  still().folders.insert(absolute(path));
}

void expect_missing_folders() {
  still().any_folder = true;
}

const UnopenedFile& unopened_file() {
  return unopened();
}

std::vector<StillFile> still_files() {
  std::vector<StillFile> list;
  for (const auto& [whole, there] : still().files) {
    struct stat found;
    list.push_back({still().names[whole], stat(there.c_str(), &found) == 0 ? double(found.st_size) : 0.0});
  }
  return list;
}

void forget_still_files() {
  Still& s = still();
  if (s.folder.empty()) return;
  nftw(s.folder.c_str(), remove_entry, 16, FTW_DEPTH | FTW_PHYS);
  s.folder.clear();
  s.files.clear();
}

}  // namespace twogrid

extern "C" {

FILE* fopen(const char* path, const char* mode) {
  static twogrid::Open* const real = twogrid::original<twogrid::Open>("fopen");
  return twogrid::open_still(real, path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  static twogrid::Open* const real = twogrid::original<twogrid::Open>("fopen64");
  return twogrid::open_still(real, path, mode);
}

FILE* popen(const char* command, const char* mode) {
  static auto* const real = twogrid::original<FILE*(const char*, const char*)>("popen");
  // gzip > FILE
  return real(twogrid::still().on && mode && mode[0] == 'w' ? "cat > /dev/null" : command, mode);
}

int mkdir(const char* path, mode_t mode) noexcept {
  static auto* const real = twogrid::original<int(const char*, mode_t)>("mkdir");
  if (!twogrid::still().on) return real(path, mode);
  const std::string whole = twogrid::absolute(path);
  if (twogrid::passes(whole)) return real(path, mode);
  twogrid::still().folders.insert(whole);
  return 0;
}

int rename(const char* from, const char* to) noexcept {
  static auto* const real = twogrid::original<int(const char*, const char*)>("rename");
  if (!twogrid::still().on || twogrid::passes(twogrid::absolute(from))) return real(from, to);
  return 0;
}
}
