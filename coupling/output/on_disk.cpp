#include "coupling/output/on_disk.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace twogrid {

namespace fs = std::filesystem;

std::string sync_to_disk(const std::string& path) {
  std::error_code e;
  const bool folder = fs::is_directory(path, e);
  const int f = open(path.c_str(), folder ? O_RDONLY | O_DIRECTORY : O_RDONLY);
  if (f < 0) return std::strerror(errno);
  std::string why = fsync(f) == 0 || (folder && errno == EINVAL) ? "" : std::strerror(errno);
  close(f);
  return why;
}

std::string put_in_place(const std::string& from, const std::string& to) {
  std::string why = sync_to_disk(from);
  if (why.empty() && std::rename(from.c_str(), to.c_str()) != 0) why = std::strerror(errno);
  if (!why.empty()) return why;
  const std::string folder = fs::path(to).parent_path().string();
  sync_to_disk(folder.empty() ? "." : folder);
  return "";
}

}  // namespace twogrid
