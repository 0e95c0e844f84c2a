#include "coupling/output/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

namespace twogrid {

namespace {
const std::string kBegin = "process ";
}

std::string real_path(const std::string& path, int links) {
  char* const real = realpath(path.c_str(), nullptr);
  if (real) {
    std::string s = real;
    std::free(real);
    return s;
  }
  std::string target(4096, '\0');
  const ssize_t n = readlink(path.c_str(), target.data(), target.size());
  if (n <= 0 || links == 0) return path;
  target.resize(std::size_t(n));
  const auto slash = path.find_last_of('/');
  if (target[0] != '/' && slash != std::string::npos) target = path.substr(0, slash + 1) + target;
  return real_path(target, links - 1);
}

bool FileLock::take(const std::string& path) {
  release();
  path_ = path + ".lock";
  // Another run that ends removes the file it holds: then once more, with a new one.
  for (int attempt = 0; attempt < 100; ++attempt) {
    file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file_ < 0) return true;
    if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const bool taken = errno == EWOULDBLOCK;
      char text[200];
      const ssize_t n = pread(file_, text, sizeof text, 0);
      who_.assign(text, n > 0 ? std::size_t(n) : 0);
      ::close(file_);
      file_ = -1;
      return !taken;
    }
    char text[8];
    const ssize_t n = pread(file_, text, sizeof text, 0);
    if (n > 0 && std::string(text, std::size_t(n)).compare(0, 8, kBegin) != 0) {  // somebody's own: left alone
      ::close(file_);
      file_ = -1;
      return true;
    }
    struct stat held, there;
    if (fstat(file_, &held) == 0 && stat(path_.c_str(), &there) == 0 && held.st_ino == there.st_ino) {
      char host[64] = "";
      gethostname(host, sizeof host - 1);
      who_ = kBegin + std::to_string(getpid()) + " on " + host;
      if (ftruncate(file_, 0) == 0 && pwrite(file_, who_.data(), who_.size(), 0) < 0) who_.clear();
      return true;
    }
    ::close(file_);
    file_ = -1;
  }
  return true;
}

void FileLock::release() {
  if (file_ < 0) return;
  unlink(path_.c_str());
  ::close(file_);
  file_ = -1;
}

}  // namespace twogrid
