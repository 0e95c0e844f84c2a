#include "coupling/output/hdf5_tools.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <numeric>

namespace twogrid {

std::string innermost_error() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* e, void* out) -> herr_t {
        if (n == 0 && e->desc) *static_cast<std::string*>(out) = e->desc;
        return 0;
      },
      &text);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

std::vector<hsize_t> dims(const std::vector<std::size_t>& v) {
  return {v.begin(), v.end()};
}

std::size_t product(const std::vector<std::size_t>& v) {
  return std::accumulate(v.begin(), v.end(), std::size_t(1), std::multiplies<>());
}

hid_t simple_space(const std::vector<std::size_t>& extent) {
  if (extent.empty()) return H5Screate(H5S_SCALAR);
  return H5Screate_simple(int(extent.size()), dims(extent).data(), nullptr);
}

bool put_attribute(hid_t file, const std::string& object, const std::string& name, hid_t type, hid_t space,
                   const void* value) {
  Handle o(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
  if (o < 0) return false;
  if (H5Aexists(o, name.c_str()) > 0) {
    // Where it has the same form only its value is written over.
    Handle a(H5Aopen(o, name.c_str(), H5P_DEFAULT), H5Aclose);
    Handle its_type(H5Aget_type(a), H5Tclose), its_space(H5Aget_space(a), H5Sclose);
    if (H5Tequal(its_type, type) > 0 && H5Sextent_equal(its_space, space) > 0) return H5Awrite(a, type, value) >= 0;
  }
  if (H5Aexists(o, name.c_str()) > 0) H5Adelete(o, name.c_str());
  Handle a(H5Acreate2(o, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return a >= 0 && H5Awrite(a, type, value) >= 0;
}

hid_t string_type(std::size_t length) {
  const hid_t t = H5Tcopy(H5T_C_S1);
  H5Tset_size(t, std::max<std::size_t>(1, length));
  H5Tset_strpad(t, H5T_STR_NULLPAD);
  H5Tset_cset(t, H5T_CSET_UTF8);
  return t;
}

hid_t unfilled_dataset() {
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  return creation;
}

constexpr std::size_t kMostAttribute = 1 << 20;  // values or characters; HDF5 itself takes 64 kB

std::vector<std::size_t> extent_of(hid_t file, const std::string& dataset) {
  Handle set(H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  Handle space(set < 0 ? -1 : H5Dget_space(set), H5Sclose);
  const int rank = space < 0 ? 0 : H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> n(std::max(rank, 0));
  if (rank > 0) H5Sget_simple_extent_dims(space, n.data(), nullptr);
  return {n.begin(), n.end()};
}

std::string text_attribute_of(hid_t file, const std::string& object, const std::string& name) {
  Handle o(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
  Handle a(o < 0 ? -1 : H5Aopen(o, name.c_str(), H5P_DEFAULT), H5Aclose);
  Handle type(a < 0 ? -1 : H5Aget_type(a), H5Tclose), space(a < 0 ? -1 : H5Aget_space(a), H5Sclose);
  if (type < 0 || space < 0 || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return "";
  if (H5Tget_size(type) > kMostAttribute || H5Sget_simple_extent_npoints(space) != 1) return "";
  std::string value(H5Tget_size(type), '\0');
  return H5Aread(a, type, value.data()) < 0 ? "" : value.c_str();
}

std::vector<int> whole_attribute_of(hid_t file, const std::string& object, const std::string& name) {
  Handle o(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
  Handle a(o < 0 ? -1 : H5Aopen(o, name.c_str(), H5P_DEFAULT), H5Aclose);
  Handle space(a < 0 ? -1 : H5Aget_space(a), H5Sclose);
  const hssize_t n = space < 0 ? 0 : H5Sget_simple_extent_npoints(space);
  if (n > hssize_t(kMostAttribute)) return {};
  std::vector<int> value(std::max<hssize_t>(n, 0));
  if (!value.empty() && H5Aread(a, H5T_NATIVE_INT, value.data()) < 0) value.clear();
  return value;
}

std::string reserve(const std::string& path, bool create, double bytes, const std::string& keyword) {
  const std::string remedy =
      "; give the path of a file in a directory that exists and may be written (fix_modify ID " + keyword + ")";
  auto refusal = [&](const std::string& why) { return "the file '" + path + "' cannot be written (" + why + ")"; };
  struct stat s;
  if (stat(path.c_str(), &s) == 0 && !S_ISREG(s.st_mode)) return refusal("it is not a regular file") + remedy;
  const int f = open(path.c_str(), create ? O_WRONLY | O_CREAT : O_WRONLY, 0666);
  if (f < 0) return refusal(std::strerror(errno)) + remedy;
  std::string why;
  if (fstat(f, &s) != 0) why = std::strerror(errno);
  const off_t from = create ? 0 : s.st_size, count = off_t(bytes);
  if (why.empty() && count > 0 && fallocate(f, 0, from, count) != 0) {
    struct statvfs disk;
    if (errno != EOPNOTSUPP)
      why = std::strerror(errno);
    else if (fstatvfs(f, &disk) == 0 && double(disk.f_bavail) * double(disk.f_frsize) < bytes)
      why = "its disk is full";
    if (!why.empty() && ftruncate(f, s.st_size) != 0) why += ", " + std::string(std::strerror(errno));
  }
  ::close(f);
  if (why.empty()) return "";
  return refusal(why) + ": the next " + std::to_string((long long)(bytes / 1024) + 1) +
         " kB have no room; free some space, write fewer frames (fix_modify ID output every), or elsewhere (fix_modify "
         "ID " +
         keyword + ")";
}

}  // namespace twogrid
