// An HDF5 file driver for one process under which a file that is there can be read at any moment, whatever becomes of the
// process: what HDF5 writes beyond the file's end as it was goes to the disk, where nobody looks yet; what it would write
// over (its own tables of what lies where) is held back in memory until commit(), which is a handful of small writes in an
// order such that the file is whole after each of them.
#pragma once

#include <map>
#include <string>

namespace twogrid {

class HeldWrites {
 public:
  /// Opens or creates (over an older one) the file. Returns HDF5's handle, negative where it can't. No lock is taken:
  /// others may read meanwhile. It must live until the handle is closed.
  long open(const std::string& path, bool create);
  /// The same, to read.
  static long open_to_read(const std::string& path);
  /// After the handle is closed: writes what was held back, and gives the file its length. Empty: done; else why not.
  std::string commit();
  /// For tests: commit() comes to its end after so many of its writes, as if the process were killed there; negative: none.
  static int killed_after;
  /// Writes of the last commit().
  static int writes;

  struct Driver;

 private:
  void hold(unsigned long long at, const char* bytes, std::size_t count);
  void show(unsigned long long at, char* bytes, std::size_t count) const;

  std::string path_;
  unsigned long long end_ = 0;   // of the file as HDF5 knew it when it was opened: below it, writes are held
  unsigned long long size_ = 0;  // of the file now, as HDF5 knows it
  std::map<unsigned long long, std::string> held_;  // by address; they neither overlap nor touch
};

}  // namespace twogrid
