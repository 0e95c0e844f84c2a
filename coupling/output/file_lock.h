// Keeps a second run off the files of the first while that runs. The lock lies on a file of its own beside them, so that
// it is in nobody's way who reads; the system takes it off when the process ends, however it ends.
#pragma once

#include <string>

namespace twogrid {

/// What links lead to, there or not: the file to lock, or to put another in the place of.
std::string real_path(const std::string& path, int links = 20);

class FileLock {
 public:
  FileLock() = default;
  ~FileLock() { release(); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// Locks `path`.lock. Returns false where another process, or another FileLock, holds it; who() then says which. On a
  /// file system without locks, or where no file can be made: true.
  bool take(const std::string& path);
  const std::string& who() const { return who_; }
  /// Removes the file.
  void release();

 private:
  int file_ = -1;
  std::string path_, who_;
};

}  // namespace twogrid
