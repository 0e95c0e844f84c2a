#include "coupling/output/hdf5_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "cfd/parallel/ranks.h"
#include "coupling/output/hdf5_tools.h"

namespace twogrid {

namespace {

herr_t select(hid_t space, const std::vector<std::size_t>& offset, const std::vector<std::size_t>& count, int rank) {
  if (product(count) == 0 || (count.empty() && rank != 0)) return H5Sselect_none(space);
  if (count.empty()) return H5Sselect_all(space);
  return H5Sselect_hyperslab(space, H5S_SELECT_SET, dims(offset).data(), nullptr, dims(count).data(), nullptr);
}

/// Why it can't be read, in a sentence; empty: it can.
std::string unreadable(const std::string& path, const std::string& keyword) {
  const std::string begin = "the file '" + path + "' cannot be read (",
                    end = "); wanted: an HDF5 file that fix_modify ID " + keyword + " can read";
  if (access(path.c_str(), R_OK) != 0) return begin + std::strerror(errno) + end;
  Quiet quiet;
  return H5Fis_hdf5(path.c_str()) > 0 ? "" : begin + "it is no HDF5 file, or only a part of one" + end;
}

}  // namespace

Hdf5File::Hdf5File(MPI_Comm comm, const std::string& path, Mode mode, double bytes, const std::string& keyword)
    : comm_(comm), path_(path), keyword_(keyword), reads_(mode == Mode::kRead) {
  rank_ = rank_of(comm);
  if (reads_)
    agree(rank_ == 0 ? unreadable(path, keyword) : "");
  else
    agree(rank_ == 0 ? reserve(path, true, bytes, keyword) : "");

  Quiet quiet;
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  H5Pset_coll_metadata_write(access, true);
  if (!reads_) H5Pset_all_coll_metadata_ops(access, true);
  file_ = reads_ ? H5Fopen(path.c_str(), H5F_ACC_RDONLY, access)
                 : H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  int bad = file_ < 0, any = 0;
  MPI_Allreduce(&bad, &any, 1, MPI_INT, MPI_MAX, comm);
  if (any) {
    failed(reads_ ? "opening it" : "creating it");
    close();
  }
}

Hdf5File::~Hdf5File() {
  Quiet quiet;
  if (file_ >= 0) H5Fclose(file_);
}

std::string Hdf5File::library_version() {
  unsigned a, b, c;
  H5get_libversion(&a, &b, &c);
  return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

void Hdf5File::agree(std::string sentence) const {
  unsigned long n = sentence.size();
  MPI_Bcast(&n, 1, MPI_UNSIGNED_LONG, 0, comm_);
  if (n == 0) return;
  sentence.resize(n);
  MPI_Bcast(sentence.data(), int(n), MPI_CHAR, 0, comm_);
  throw std::runtime_error(sentence);
}

void Hdf5File::failed(const std::string& what) {
  if (!ok_) return;
  ok_ = false;
  const std::string detail = innermost_error();
  failure_ = what + (detail.empty() ? "" : ": " + detail);
}

void Hdf5File::unfit(const std::string& what) {
  if (!ok_) return;
  ok_ = false;
  failure_ = what;
}

void Hdf5File::group(const std::string& path) {
  Quiet quiet;
  if (H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0) return;
  Handle g(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  if (g < 0) failed("group " + path);
}

void Hdf5File::attribute(const std::string& object, const std::string& name, const std::string& value) {
  Quiet quiet;
  Handle type(string_type(value.size()), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!put_attribute(file_, object, name, type, space, value.c_str())) failed("attribute " + name);
}

void Hdf5File::attribute(const std::string& object, const std::string& name, double value) {
  Quiet quiet;
  Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!put_attribute(file_, object, name, H5T_NATIVE_DOUBLE, space, &value)) failed("attribute " + name);
}

void Hdf5File::attribute(const std::string& object, const std::string& name, const std::vector<int>& value) {
  Quiet quiet;
  Handle space(simple_space({value.size()}), H5Sclose);
  if (!put_attribute(file_, object, name, H5T_NATIVE_INT, space, value.data())) failed("attribute " + name);
}

void Hdf5File::write(const std::string& path, const Slab& s, long type, const void* value, const std::string& unit) {
  Quiet quiet;
  const bool exists = H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
  Handle file_space(simple_space(s.extent), H5Sclose);
  Handle creation(unfilled_dataset(), H5Pclose);
  Handle set(exists ? H5Dopen2(file_, path.c_str(), H5P_DEFAULT)
                    : H5Dcreate2(file_, path.c_str(), type, file_space, H5P_DEFAULT, creation, H5P_DEFAULT),
             H5Dclose);
  Handle memory_space(simple_space(s.memory_extent.empty() ? s.count : s.memory_extent), H5Sclose);
  Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  if (set < 0) return failed("dataset " + path);
  const std::vector<std::size_t> packed(s.count.size(), 0);
  if (select(file_space, s.offset, s.count, rank_) < 0 ||
      select(memory_space, s.memory_offset.empty() ? packed : s.memory_offset, s.count, rank_) < 0)
    failed("selection in " + path);
  if (product(s.extent) > 0 && H5Dwrite(set, type, memory_space, file_space, transfer, value) < 0)
    failed("writing " + path);
  if (!unit.empty() && !exists) {
    Handle text(string_type(unit.size()), H5Tclose), scalar(H5Screate(H5S_SCALAR), H5Sclose);
    if (!put_attribute(file_, path, "unit", text, scalar, unit.c_str())) failed("unit of " + path);
  }
}

void Hdf5File::slab(const std::string& path, const Slab& s, const double* value, const std::string& unit) {
  write(path, s, H5T_NATIVE_DOUBLE, value, unit);
}

void Hdf5File::slab(const std::string& path, const Slab& s, const int* value, const std::string& unit) {
  write(path, s, H5T_NATIVE_INT, value, unit);
}

void Hdf5File::replicated(const std::string& path, const std::vector<double>& value,
                          const std::vector<std::size_t>& extent, const std::string& unit) {
  Slab s;
  s.extent = extent;
  s.offset.assign(extent.size(), 0);
  s.count = extent;
  if (rank_ != 0) s.count.assign(extent.size(), 0);
  write(path, s, H5T_NATIVE_DOUBLE, value.data(), unit);
}

void Hdf5File::text(const std::string& path, const std::string& value) {
  Handle type(string_type(value.size()), H5Tclose);
  std::string copy = value;
  copy.resize(std::max<std::size_t>(1, copy.size()));
  write(path, Slab{}, type, copy.data(), "");
}

bool Hdf5File::has(const std::string& path) const {
  Quiet quiet;
  return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::size_t> Hdf5File::extent(const std::string& path) const {
  Quiet quiet;
  return extent_of(file_, path);
}

std::string Hdf5File::text_attribute(const std::string& object, const std::string& name) {
  Quiet quiet;
  std::string value = text_attribute_of(file_, object, name);
  if (value.empty()) failed("attribute " + name);
  return value;
}

std::vector<int> Hdf5File::whole_attribute(const std::string& object, const std::string& name) {
  Quiet quiet;
  std::vector<int> value = whole_attribute_of(file_, object, name);
  if (value.empty()) failed("attribute " + name);
  return value;
}

void Hdf5File::read(const std::string& path, const Slab& s, double* value) {
  read(path, s, H5T_NATIVE_DOUBLE, value);
}

void Hdf5File::read(const std::string& path, const Slab& s, int* value) {
  read(path, s, H5T_NATIVE_INT, value);
}

bool Hdf5File::holds(const std::string& path, const std::vector<std::size_t>& extent) const {
  hsize_t bytes = 0;
  return this->extent(path) == extent && H5Fget_filesize(file_, &bytes) >= 0 &&
         std::all_of(extent.begin(), extent.end(), [&](std::size_t n) { return n <= bytes; }) &&
         double(product(extent)) <= double(bytes);
}

std::vector<double> Hdf5File::whole(const std::string& path) {
  Slab s;
  s.extent = s.count = has(path) ? extent(path) : std::vector<std::size_t>{0};
  s.offset.assign(s.extent.size(), 0);
  if (has(path) && !holds(path, s.extent)) return failed(path + " is larger than its file"), std::vector<double>{};
  std::vector<double> all(s.extent.empty() ? 0 : product(s.extent));
  if (!all.empty()) read(path, s, all.data());
  return all;
}

void Hdf5File::read(const std::string& path, const Slab& s, long type, void* value) {
  if (product(s.count) == 0) return;
  Quiet quiet;
  if (extent(path) != s.extent) return failed(path + " is not there, or of another size");
  Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  Handle file_space(simple_space(s.extent), H5Sclose);
  Handle memory_space(simple_space(s.memory_extent.empty() ? s.count : s.memory_extent), H5Sclose);
  const std::vector<std::size_t> packed(s.count.size(), 0);
  const auto part = [&](hid_t space, const std::vector<std::size_t>& offset) {
    return H5Sselect_hyperslab(space, H5S_SELECT_SET, dims(offset).data(), nullptr, dims(s.count).data(), nullptr) >= 0;
  };
  if (!part(file_space, s.offset) || !part(memory_space, s.memory_offset.empty() ? packed : s.memory_offset) ||
      H5Dread(set, type, memory_space, file_space, H5P_DEFAULT, value) < 0)
    failed("reading " + path);
}

void Hdf5File::close() {
  {
    Quiet quiet;
    if (file_ >= 0) {
      if (!reads_ && H5Fflush(file_, H5F_SCOPE_GLOBAL) < 0) failed("flushing it");
      if (H5Fclose(file_) < 0) failed("closing it");
      file_ = -1;
    }
  }
  const int ranks = ranks_of(comm_);
  int first = ok_ ? ranks : rank_, whose = ranks;
  MPI_Allreduce(&first, &whose, 1, MPI_INT, MPI_MIN, comm_);
  if (whose == ranks) return;
  unsigned long n = failure_.size();
  MPI_Bcast(&n, 1, MPI_UNSIGNED_LONG, whose, comm_);
  failure_.resize(n);
  MPI_Bcast(failure_.data(), int(n), MPI_CHAR, whose, comm_);
  if (reads_)
    throw std::runtime_error("the file '" + path_ + "' does not hold what is wanted of it (" + failure_ +
                             "); give another one (fix_modify ID " + keyword_ + ")");
  throw std::runtime_error("the file '" + path_ + "' could not be written (" + failure_ +
                           "); see whether its disk is full, or give another path (fix_modify ID " + keyword_ + ")");
}

}  // namespace twogrid
