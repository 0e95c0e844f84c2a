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
  bool blanks = false;  ///< bytes that tell ParaView which cells not to show (vtkGhostType)
};

/// Of grids that bodies cut: the open share of cells, and those that ParaView leaves out. grid: /grid or /particle_grid.
std::vector<XdmfField> open_fields(const std::string& grid);

/// A rectilinear grid of n cells whose node coordinates are the datasets nodes/x, /y, /z, with a value a cell.
std::string xdmf_grid(const std::string& name, const std::string& h5, const std::string& nodes, const Int3& n,
                      const std::vector<XdmfField>& fields);

/// `count` points whose coordinates are the dataset `position`, with a value a point.
std::string xdmf_points(const std::string& name, const std::string& h5, const std::string& position, long long count,
                        const std::vector<XdmfField>& fields);

/// Surfaces of bodies, whose geometry is in the group /grid/walls: numbers of facets, of points, and of entries of the
/// list of polygons.
struct XdmfSurface {
  long long facets = 0, points = 0, topology = 0;
};

/// With friction and pressure of a group, such as /walls/000012/.
std::string xdmf_surface(const std::string& h5, const XdmfSurface& surface, const std::string& group);

/// A frame: what of it is shown. The paths of its fields follow from their names (output.h has the layout), but where one
/// is given.
struct XdmfFrame {
  std::string h5, name;  ///< the HDF5 file, relative to the XDMF file; of the frame in it
  double time = 0;       ///< s
  double step = 0;
  Int3 n{0, 0, 0};  ///< cells
  std::vector<XdmfField> cells, points;
  long long particles = 0;  ///< shown, if any
  XdmfSurface walls;        ///< the same
};

/// Writes a file that shows these grids, without time, in place of an older one. Throws std::runtime_error with a
/// sentence.
void write_xdmf(const std::string& path, const std::string& grids);

/// A time series. Each frame is put in place of the file's last lines, which are then written again: the file is
/// complete after every frame.
class XdmfSeries {
 public:
  /// Writes a series of these frames, in place of an older file. Throws std::runtime_error with a sentence.
  explicit XdmfSeries(const std::string& path, const std::vector<XdmfFrame>& frames = {});
  /// Throws std::runtime_error with a sentence.
  void add(const XdmfFrame& frame);

 private:
  std::string path_;
  long end_ = 0;  // where the last lines begin
};

}  // namespace twogrid
