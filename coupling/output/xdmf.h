// The XDMF description (https://www.xdmf.org, version 2) of an HDF5 file, so that ParaView opens it: text only, the
// values stay in the HDF5 file. Used by one rank.
#pragma once

#include <string>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

/// A dataset shown in ParaView: its path inside the HDF5 file, 1 (scalar) or 3 (vector) components.
struct XdmfField {
  std::string name, path;
  int components = 1;
  bool integer = false;
};

/// A rectilinear grid of n cells whose node coordinates are the datasets nodes/x, /y, /z, with a value a cell.
std::string xdmf_grid(const std::string& name, const std::string& h5, const std::string& nodes, const Int3& n,
                      const std::vector<XdmfField>& fields);

/// `count` points whose coordinates are the dataset `position`, with a value a point.
std::string xdmf_points(const std::string& name, const std::string& h5, const std::string& position, long long count,
                        const std::vector<XdmfField>& fields);

/// Writes a file that shows these grids, without time. Throws std::runtime_error with a sentence.
void write_xdmf(const std::string& path, const std::string& grids);

/// A time series. Each frame is put in place of the file's last lines, which are then written again: the file is
/// complete after every frame.
class XdmfSeries {
 public:
  /// Writes a series without frames. Throws std::runtime_error with a sentence.
  explicit XdmfSeries(const std::string& path);
  /// grids: what xdmf_grid and xdmf_points give. Throws std::runtime_error with a sentence.
  void add(double time, const std::string& grids);

 private:
  void write(long at, const std::string& text) const;
  std::string path_;
  long end_ = 0;  // where the last lines begin
};

}  // namespace twogrid
