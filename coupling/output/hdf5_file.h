// One HDF5 file that all ranks of a communicator write, from its beginning to its end, or read together (MPI-IO). The file
// is open between the constructor and close(). A file that grows is another kind: growing_file.h.
//
// A call that fails does not throw by itself: the other ranks would wait for ever in their next collective call. The
// first failure is remembered, close() tells all ranks and throws on all of them.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <string>
#include <vector>

namespace twogrid {

/// Which part of a dataset a rank writes, and where these values lie in its memory; slowest dimension first. A count of
/// zero in any dimension: the rank writes nothing.
struct Slab {
  std::vector<std::size_t> extent;  ///< of the dataset, the same on all ranks; empty: a scalar, written by rank 0
  std::vector<std::size_t> offset, count;                 ///< of the rank's part
  std::vector<std::size_t> memory_extent, memory_offset;  ///< of the array it is taken from; empty: packed, no gaps
};

class Hdf5File {
 public:
  enum class Mode { kCreate, kRead };

  /// Room for `bytes` more (of all ranks, an upper bound) is reserved on the disk first, so that a full disk is met
  /// before anything is written. Collective. Throws std::runtime_error with a sentence on
  /// all ranks when there is no such room or the file can't be created or opened. keyword: of the script, that names the
  /// file, for the sentences. kRead: an existing file, bytes don't count.
  Hdf5File(MPI_Comm comm, const std::string& path, Mode mode, double bytes, const std::string& keyword = "output file");
  /// Closes without a word; call close() to know.
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  static std::string library_version();

  // All of the following are collective, with the same names and extents on all ranks. A dataset that exists already is
  // written over, its extent must be the same.
  void group(const std::string& path);
  void attribute(const std::string& object, const std::string& name, const std::string& value);
  void attribute(const std::string& object, const std::string& name, double value);
  void attribute(const std::string& object, const std::string& name, const std::vector<int>& value);
  /// Values of rank 0. An empty extent: a scalar.
  void text(const std::string& path, const std::string& value);
  void replicated(const std::string& path, const std::vector<double>& value, const std::vector<std::size_t>& extent,
                  const std::string& unit = "");
  /// Every rank its part.
  void slab(const std::string& path, const Slab& slab, const double* value, const std::string& unit = "");
  void slab(const std::string& path, const Slab& slab, const int* value, const std::string& unit = "");

  // Reading, of a file opened for it. What is not there, or not of this kind, is a failure: close() tells.
  bool has(const std::string& path) const;                         ///< Local.
  std::vector<std::size_t> extent(const std::string& path) const;  ///< of a dataset; empty: a scalar. Local.
  std::string text_attribute(const std::string& object, const std::string& name);
  std::vector<int> whole_attribute(const std::string& object, const std::string& name);
  /// This rank's part. Local: ranks may read other parts, or none.
  void read(const std::string& path, const Slab& slab, double* value);
  void read(const std::string& path, const Slab& slab, int* value);
  /// Whether there is a dataset of this extent, and the file large enough for it: else its numbers are mere promises,
  /// for which nothing is to be allocated. Local.
  bool holds(const std::string& path, const std::vector<std::size_t>& extent) const;
  /// All of it, as one list; empty where it isn't there. Local.
  std::vector<double> whole(const std::string& path);
  /// Whoever reads finds that it can't be what is wanted. A failure, like those above. Local.
  void unfit(const std::string& what);

  /// Flushes and closes. Throws std::runtime_error with a sentence on all ranks if anything failed on any of them.
  void close();

 private:
  void write(const std::string& path, const Slab& slab, long type, const void* value, const std::string& unit);
  void read(const std::string& path, const Slab& slab, long type, void* value);
  void failed(const std::string& what);
  /// Rank 0 found what is wrong (empty: nothing): throws it on all ranks.
  void agree(std::string sentence) const;

  MPI_Comm comm_;
  int rank_ = 0;
  std::string path_, keyword_;
  bool reads_ = false;
  long file_ = -1;
  bool ok_ = true;
  std::string failure_;  // the first one
};

}  // namespace twogrid
