// What the files that speak HDF5 share. Included by them alone.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <string>
#include <vector>

namespace twogrid {

static_assert(sizeof(long) == sizeof(hid_t), "handles are kept as long");

/// While it lives, HDF5 prints no error stack of its own.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// An HDF5 handle and the function that releases it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), release_(release) {}
  ~Handle() {
    if (id_ >= 0) release_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*release_)(hid_t);
};

/// Innermost description of HDF5's error stack.
std::string innermost_error();

std::vector<hsize_t> dims(const std::vector<std::size_t>& v);
std::size_t product(const std::vector<std::size_t>& v);
/// An empty extent: a scalar.
hid_t simple_space(const std::vector<std::size_t>& extent);
hid_t string_type(std::size_t length);
/// Writes an attribute of an object, in place of an older one. Returns false when HDF5 refuses.
bool put_attribute(hid_t file, const std::string& object, const std::string& name, hid_t type, hid_t space,
                   const void* value);
/// Properties of a dataset that gets every value once, by its owner.
hid_t unfilled_dataset();

std::vector<std::size_t> extent_of(hid_t file, const std::string& dataset);
/// Empty where it is not there, or no text.
std::string text_attribute_of(hid_t file, const std::string& object, const std::string& name);
std::vector<int> whole_attribute_of(hid_t file, const std::string& object, const std::string& name);

/// Opens the file (or makes it), reserves room beyond its end (from its start, if it will be written anew), and says in
/// a sentence why that is impossible; empty: it is possible. HDF5 and MPI give no reason, and end badly on a full disk.
/// keyword: of the script, that names the file.
std::string reserve(const std::string& path, bool create, double bytes, const std::string& keyword);

}  // namespace twogrid
