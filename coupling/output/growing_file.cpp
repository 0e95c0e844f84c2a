#include "coupling/output/growing_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "cfd/parallel/rank_0.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/hdf5_tools.h"

namespace twogrid {

namespace {

/// A box of an array as MPI describes it, slowest dimension first.
MPI_Datatype part_of_array(const std::vector<std::size_t>& extent, const std::vector<std::size_t>& count,
                           const std::vector<std::size_t>& offset, MPI_Datatype number) {
  const std::vector<int> n(extent.begin(), extent.end()), m(count.begin(), count.end()),
      at(offset.begin(), offset.end());
  MPI_Datatype type;
  MPI_Type_create_subarray(int(n.size()), n.data(), m.data(), at.data(), MPI_ORDER_C, number, &type);
  MPI_Type_commit(&type);
  return type;
}

std::string mpi_error(int code) {
  char text[MPI_MAX_ERROR_STRING];
  int n = 0;
  MPI_Error_string(code, text, &n);
  return std::string(text, std::size_t(n));
}

}  // namespace

GrowingFile::GrowingFile(MPI_Comm comm, const std::string& path, bool create, double bytes)
    : comm_(comm), rank_(rank_of(comm)), path_(path) {
  on_rank_0(comm_, [&] {
    struct stat s;
    before_ = stat(path.c_str(), &s) == 0 && !create ? (long long)s.st_size : 0;
    const std::string why = reserve(path, create, bytes, "output file");
    if (!why.empty()) throw std::runtime_error(why);
    Quiet quiet;
    file_ = held_.open(path, create);
    if (file_ >= 0) return;
    const std::string detail = innermost_error();
    if (!create && truncate(path.c_str(), off_t(before_)) != 0) before_ = 0;
    throw std::runtime_error("the file '" + path + "' could not be " + (create ? "created" : "opened") + " (" + detail +
                             "); give another path (fix_modify ID output file)");
  });
  open_ = true;
}

GrowingFile::~GrowingFile() {
  if (open_) leave();
}

void GrowingFile::failed(const std::string& what) {
  if (!failure_.empty()) return;
  const std::string detail = innermost_error();
  failure_ = what + (detail.empty() ? "" : ": " + detail);
}

void GrowingFile::group(const std::string& path, std::size_t names) {
  if (rank_ != 0) return;
  Quiet quiet;
  if (H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0) return;
  Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  if (names > 0) H5Pset_local_heap_size_hint(creation, names);
  Handle g(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
  if (g < 0) failed("group " + path);
}

void GrowingFile::attribute(const std::string& object, const std::string& name, const std::string& value) {
  if (rank_ != 0) return;
  Quiet quiet;
  Handle type(string_type(value.size()), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!put_attribute(file_, object, name, type, space, value.c_str())) failed("attribute " + name);
}

void GrowingFile::attribute(const std::string& object, const std::string& name, double value) {
  if (rank_ != 0) return;
  Quiet quiet;
  Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!put_attribute(file_, object, name, H5T_NATIVE_DOUBLE, space, &value)) failed("attribute " + name);
}

void GrowingFile::attribute(const std::string& object, const std::string& name, const std::vector<int>& value) {
  if (rank_ != 0) return;
  Quiet quiet;
  Handle space(simple_space({value.size()}), H5Sclose);
  if (!put_attribute(file_, object, name, H5T_NATIVE_INT, space, value.data())) failed("attribute " + name);
}

void GrowingFile::remove(const std::string& path) {
  if (rank_ != 0) return;
  Quiet quiet;
  if (H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0 && H5Ldelete(file_, path.c_str(), H5P_DEFAULT) < 0)
    failed("removing " + path);
}

long GrowingFile::dataset(const std::string& path, const std::vector<std::size_t>& extent, long type,
                          const std::string& unit) {
  if (H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0) return H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
  Handle space(simple_space(extent), H5Sclose);
  Handle creation(unfilled_dataset(), H5Pclose);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  const hid_t set = H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  if (set >= 0 && !unit.empty()) {
    Handle text(string_type(unit.size()), H5Tclose), scalar(H5Screate(H5S_SCALAR), H5Sclose);
    if (!put_attribute(file_, path, "unit", text, scalar, unit.c_str())) failed("unit of " + path);
  }
  return set;
}

void GrowingFile::replicated(const std::string& path, const std::vector<double>& value,
                             const std::vector<std::size_t>& extent, const std::string& unit) {
  if (rank_ != 0) return;
  Quiet quiet;
  Handle set(dataset(path, extent, H5T_NATIVE_DOUBLE, unit), H5Dclose);
  if (set < 0 || H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()) < 0)
    failed("writing " + path);
}

void GrowingFile::text(const std::string& path, const std::string& value) {
  if (rank_ != 0) return;
  Quiet quiet;
  std::string copy = value;
  copy.resize(std::max<std::size_t>(1, copy.size()));
  Handle type(string_type(copy.size()), H5Tclose);
  Handle set(dataset(path, {}, type, ""), H5Dclose);
  if (set < 0 || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, copy.data()) < 0) failed("writing " + path);
}

void GrowingFile::write(const std::string& path, const Slab& s, long type, MPI_Datatype number, const void* value,
                        const std::string& unit) {
  Quiet quiet;
  unsigned long long at = HADDR_UNDEF;
  if (rank_ == 0) {
    Handle set(dataset(path, s.extent, type, unit), H5Dclose);
    if (set < 0)
      failed("dataset " + path);
    else if (extent_of(file_, path) != s.extent)
      failed("dataset " + path + " is of another size");
    else
      at = H5Dget_offset(set);
  }
  MPI_Bcast(&at, 1, MPI_UNSIGNED_LONG_LONG, 0, comm_);
  if (at == HADDR_UNDEF) return;  // it has no values, or failed
  if (values_ == MPI_FILE_NULL) {
    const int code = MPI_File_open(comm_, path_.c_str(), MPI_MODE_RDWR, MPI_INFO_NULL, &values_);
    int bad = code != MPI_SUCCESS, any = 0;
    if (bad) failed("opening it by MPI-IO, " + mpi_error(code));
    MPI_Allreduce(&bad, &any, 1, MPI_INT, MPI_MAX, comm_);
    if (any) {
      if (!bad) MPI_File_close(&values_);
      values_ = MPI_FILE_NULL;
      return;
    }
  }
  const bool some = product(s.count) > 0;
  MPI_Datatype there = number, here = number;
  if (some) {
    there = part_of_array(s.extent, s.count, s.offset, number);
    const bool packed = s.memory_extent.empty();
    here = part_of_array(packed ? s.count : s.memory_extent, s.count,
                         packed ? std::vector<std::size_t>(s.count.size(), 0) : s.memory_offset, number);
  }
  int code = MPI_File_set_view(values_, MPI_Offset(at), number, there, "native", MPI_INFO_NULL);
  if (code == MPI_SUCCESS) code = MPI_File_write_at_all(values_, 0, value, some ? 1 : 0, here, MPI_STATUS_IGNORE);
  if (code != MPI_SUCCESS) failed("writing " + path + ", " + mpi_error(code));
  if (some) MPI_Type_free(&there), MPI_Type_free(&here);
}

void GrowingFile::slab(const std::string& path, const Slab& s, const double* value, const std::string& unit) {
  write(path, s, H5T_NATIVE_DOUBLE, MPI_DOUBLE, value, unit);
}

void GrowingFile::slab(const std::string& path, const Slab& s, const int* value, const std::string& unit) {
  write(path, s, H5T_NATIVE_INT, MPI_INT, value, unit);
}

void GrowingFile::leave() {
  Quiet quiet;
  if (values_ != MPI_FILE_NULL) MPI_File_close(&values_);
  if (file_ >= 0) {
    H5Fclose(file_);
    file_ = -1;
    if (truncate(path_.c_str(), off_t(before_)) != 0) failed("making it as long as before");
  }
  open_ = false;
}

void GrowingFile::close() {
  Quiet quiet;
  if (values_ != MPI_FILE_NULL) {
    const int code = MPI_File_close(&values_);
    values_ = MPI_FILE_NULL;
    if (code != MPI_SUCCESS) failed("closing it, " + mpi_error(code));
  }
  if (file_ >= 0 && H5Fflush(file_, H5F_SCOPE_GLOBAL) < 0) failed("flushing it");
  const int ranks = ranks_of(comm_);
  int first = failure_.empty() ? ranks : rank_, whose = ranks;
  MPI_Allreduce(&first, &whose, 1, MPI_INT, MPI_MIN, comm_);
  if (whose < ranks)
    leave();
  else if (file_ >= 0) {
    if (H5Fclose(file_) < 0) failed("closing it");
    file_ = -1;
    const std::string why = failure_.empty() ? held_.commit() : "";
    if (!why.empty()) failed(why);
  }
  open_ = false;
  failure_ = from_rank(comm_, whose < ranks ? whose : 0, failure_);
  if (failure_.empty()) return;
  throw std::runtime_error("the file '" + path_ + "' could not be written (" + failure_ +
                           "); see whether its disk is full, or give another path (fix_modify ID output file)");
}

}  // namespace twogrid
