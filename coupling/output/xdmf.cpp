#include "coupling/output/xdmf.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "coupling/output/file_lock.h"

namespace twogrid {

namespace {

const char kHead[] = "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"2.0\">\n<Domain>\n";
const char kTail[] = "</Domain>\n</Xdmf>\n";
const char kSeriesHead[] = "<Grid Name=\"series\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
const char kSeriesTail[] = "</Grid>\n";

/// A file's name as text of XML.
std::string escaped(const std::string& name) {
  std::string s;
  for (char c : name) {
    if (c == '&')
      s += "&amp;";
    else if (c == '<')
      s += "&lt;";
    else if (c == '>')
      s += "&gt;";
    else if (c == '"')
      s += "&quot;";
    else if (c == '\'')
      s += "&apos;";
    else
      s += c;
  }
  return s;
}

std::string item(const std::string& h5, const std::string& path, const std::string& dimensions,
                 const char* type = "NumberType=\"Float\" Precision=\"8\"") {
  return "<DataItem Format=\"HDF\" " + std::string(type) + " Dimensions=\"" + dimensions + "\">" + escaped(h5) + ":" +
         path + "</DataItem>\n";
}

std::string attributes(const std::string& h5, const std::vector<XdmfField>& fields, const char* centre,
                       const std::string& dimensions) {
  std::string s;
  for (const XdmfField& f : fields)
    s += "<Attribute Name=\"" + f.name + "\" AttributeType=\"" + (f.components == 3 ? "Vector" : "Scalar") +
         "\" Center=\"" + centre + "\">\n" +
         item(h5, f.path, dimensions + (f.components == 3 ? " 3" : ""),
              f.blanks    ? "NumberType=\"UChar\" Precision=\"1\""
              : f.integer ? "NumberType=\"Int\" Precision=\"4\""
                          : "NumberType=\"Float\" Precision=\"8\"") +
         "</Attribute>\n";
  return s;
}

std::runtime_error not_written(const std::string& path) {
  return std::runtime_error(
      "the file '" + path + "' for ParaView cannot be written (" + std::strerror(errno) +
      "); see whether its disk is full and its directory may be written (fix_modify ID output file)");
}

/// /fluid/000012/u and the like.
std::vector<XdmfField> at(const std::string& group, std::vector<XdmfField> fields) {
  for (XdmfField& f : fields)
    if (f.path.empty()) f.path = group + f.name;
  return fields;
}

std::string text_of(const XdmfFrame& f) {
  char t[40];
  std::snprintf(t, sizeof t, "%.12g", f.time);
  const std::string fluid = "/fluid/" + f.name + "/", particles = "/particles/" + f.name + "/";
  std::string grids = xdmf_grid("fluid", f.h5, "/grid", f.n, at(fluid, f.cells));
  if (f.particles > 0)
    grids += xdmf_points("particles", f.h5, particles + "position", f.particles, at(particles, f.points));
  if (f.walls.facets > 0) grids += xdmf_surface(f.h5, f.walls, "/walls/" + f.name + "/");
  return "<Grid Name=\"frame\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"" + std::string(t) +
         "\"/>\n" + grids + "</Grid>\n";
}

}  // namespace

std::vector<XdmfField> open_fields(const std::string& grid) {
  XdmfField theta{"theta", grid + "/theta"}, blank{"vtkGhostType", grid + "/blank"};
  blank.blanks = true;
  return {theta, blank};
}

std::string xdmf_grid(const std::string& name, const std::string& h5, const std::string& nodes, const Int3& n,
                      const std::vector<XdmfField>& fields) {
  auto s = [](int i) { return std::to_string(i); };
  return "<Grid Name=\"" + name + "\" GridType=\"Uniform\">\n<Topology TopologyType=\"3DRectMesh\" Dimensions=\"" +
         s(n[2] + 1) + " " + s(n[1] + 1) + " " + s(n[0] + 1) + "\"/>\n<Geometry GeometryType=\"VXVYVZ\">\n" +
         item(h5, nodes + "/x", s(n[0] + 1)) + item(h5, nodes + "/y", s(n[1] + 1)) +
         item(h5, nodes + "/z", s(n[2] + 1)) + "</Geometry>\n" +
         attributes(h5, fields, "Cell", s(n[2]) + " " + s(n[1]) + " " + s(n[0])) + "</Grid>\n";
}

std::string xdmf_points(const std::string& name, const std::string& h5, const std::string& position, long long count,
                        const std::vector<XdmfField>& fields) {
  const std::string n = std::to_string(count);
  return "<Grid Name=\"" + name +
         "\" GridType=\"Uniform\">\n<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"" + n +
         "\" NodesPerElement=\"1\"/>\n<Geometry GeometryType=\"XYZ\">\n" + item(h5, position, n + " 3") +
         "</Geometry>\n" + attributes(h5, fields, "Node", n) + "</Grid>\n";
}

std::string xdmf_surface(const std::string& h5, const XdmfSurface& surface, const std::string& group) {
  const std::string n = std::to_string(surface.facets), at = "/grid/walls/";
  XdmfField body{"body", at + "body"};
  body.integer = true;
  return "<Grid Name=\"walls\" GridType=\"Uniform\">\n<Topology TopologyType=\"Mixed\" NumberOfElements=\"" + n +
         "\">\n" + item(h5, at + "polygons", std::to_string(surface.topology), "NumberType=\"Int\" Precision=\"4\"") +
         "</Topology>\n<Geometry GeometryType=\"XYZ\">\n" +
         item(h5, at + "points", std::to_string(surface.points) + " 3") + "</Geometry>\n" +
         attributes(h5,
                    {{"friction", group + "friction", 3},
                     {"pressure", group + "pressure"},
                     body,
                     {"normal", at + "normal", 3},
                     {"area", at + "area"}},
                    "Cell", n) +
         "</Grid>\n";
}

void write_xdmf(const std::string& path, const std::string& grids) {
  // Beside it first: whoever reads finds the older file or the new one.
  const std::string target = real_path(path), part = target + ".part";
  std::FILE* f = std::fopen(part.c_str(), "w");
  if (!f) throw not_written(path);
  const std::string text = kHead + grids + kTail;
  const bool written = std::fwrite(text.data(), 1, text.size(), f) == text.size();
  if (std::fclose(f) != 0 || !written || std::rename(part.c_str(), target.c_str()) != 0) throw not_written(path);
}

XdmfSeries::XdmfSeries(const std::string& path, const std::vector<XdmfFrame>& frames) : path_(path) {
  std::string text = kSeriesHead;
  for (const XdmfFrame& f : frames) text += text_of(f);
  write_xdmf(path, text + kSeriesTail);
  end_ = long(std::strlen(kHead) + text.size());
}

void XdmfSeries::add(const XdmfFrame& frame) {
  const std::string text = text_of(frame), all = text + kSeriesTail + kTail;
  const int f = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (f < 0) throw not_written(path_);
  const bool written = pwrite(f, all.data(), all.size(), end_) == ssize_t(all.size());
  if (close(f) != 0 || !written) throw not_written(path_);
  end_ += long(text.size());
}

}  // namespace twogrid
