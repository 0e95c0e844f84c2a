// The output file: all ranks add to it together, time after time. Between the constructor and close() nothing of it that
// was there can be seen to change; close() shows what is new. A process that is killed at any moment leaves a file that
// can be read, with all that earlier close() calls have shown (held_writes.h; for groups see group()). Only the means, which are written over, may
// then be partly older and partly newer ones.
//
// Rank 0 speaks HDF5 and finds room for every dataset; all ranks put their parts there by MPI-IO.
//
// A call that fails does not throw by itself: the other ranks would wait for ever in their next collective call. The
// first failure is remembered, close() tells all ranks, leaves the file as it was, and throws on all of them.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "coupling/output/hdf5_file.h"
#include "coupling/output/held_writes.h"

namespace twogrid {

class GrowingFile {
 public:
  /// Room for `bytes` more (of all ranks, an upper bound) is reserved on the disk first, so that a full disk is met
  /// before anything is written. Collective. Throws std::runtime_error with a sentence on all ranks when there is no such
  /// room or the file can't be created (over an older one) or opened.
  GrowingFile(MPI_Comm comm, const std::string& path, bool create, double bytes);
  /// Leaves the file as it was; call close() to have it otherwise.
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  // Values and names of rank 0 count. A dataset that exists already is written over, its extent must be the same.
  /// names: bytes that the names in it will take (8 a frame); up to there a kill within close() harms nothing.
  void group(const std::string& path, std::size_t names = 0);
  void attribute(const std::string& object, const std::string& name, const std::string& value);
  void attribute(const std::string& object, const std::string& name, double value);
  void attribute(const std::string& object, const std::string& name, const std::vector<int>& value);
  void text(const std::string& path, const std::string& value);
  /// An empty extent: a scalar.
  void replicated(const std::string& path, const std::vector<double>& value, const std::vector<std::size_t>& extent,
                  const std::string& unit = "");
  void remove(const std::string& path);
  /// Every rank its part. Collective.
  void slab(const std::string& path, const Slab& slab, const double* value, const std::string& unit = "");
  void slab(const std::string& path, const Slab& slab, const int* value, const std::string& unit = "");

  /// Shows what is new. Collective. Throws std::runtime_error with a sentence on all ranks if anything failed on any of
  /// them; the file is then as it was.
  void close();

 private:
  void write(const std::string& path, const Slab& slab, long type, MPI_Datatype number, const void* value,
             const std::string& unit);
  /// Rank 0: the dataset, made where it is not there yet; negative: failed.
  long dataset(const std::string& path, const std::vector<std::size_t>& extent, long type, const std::string& unit);
  void failed(const std::string& what);
  void leave();

  MPI_Comm comm_;
  int rank_ = 0;
  std::string path_;
  HeldWrites held_;
  long file_ = -1;        // rank 0
  long long before_ = 0;  // length of the file, rank 0
  MPI_File values_ = MPI_FILE_NULL;
  bool open_ = false;
  std::string failure_;  // the first one; empty: none
};

}  // namespace twogrid
