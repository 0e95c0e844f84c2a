#include "coupling/output/xdmf.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

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

std::string item(const std::string& h5, const std::string& path, const std::string& dimensions, bool integer = false) {
  return "<DataItem Format=\"HDF\" " +
         std::string(integer ? "NumberType=\"Int\" Precision=\"4\"" : "NumberType=\"Float\" Precision=\"8\"") +
         " Dimensions=\"" + dimensions + "\">" + escaped(h5) + ":" + path + "</DataItem>\n";
}

std::string attributes(const std::string& h5, const std::vector<XdmfField>& fields, const char* centre,
                       const std::string& dimensions) {
  std::string s;
  for (const XdmfField& f : fields)
    s += "<Attribute Name=\"" + f.name + "\" AttributeType=\"" + (f.components == 3 ? "Vector" : "Scalar") +
         "\" Center=\"" + centre + "\">\n" + item(h5, f.path, dimensions + (f.components == 3 ? " 3" : ""), f.integer) +
         "</Attribute>\n";
  return s;
}

std::runtime_error not_written(const std::string& path) {
  return std::runtime_error(
      "the file '" + path + "' for ParaView cannot be written (" + std::strerror(errno) +
      "); see whether its disk is full and its directory may be written (fix_modify ID output file)");
}

}  // namespace

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

void write_xdmf(const std::string& path, const std::string& grids) {
  std::FILE* f = std::fopen(path.c_str(), "w");
  if (!f) throw not_written(path);
  const std::string text = kHead + grids + kTail;
  const bool written = std::fwrite(text.data(), 1, text.size(), f) == text.size();
  if (std::fclose(f) != 0 || !written) throw not_written(path);
}

XdmfSeries::XdmfSeries(const std::string& path) : path_(path) {
  write_xdmf(path, std::string(kSeriesHead) + kSeriesTail);
  end_ = long(std::strlen(kHead) + std::strlen(kSeriesHead));
}

void XdmfSeries::add(double time, const std::string& grids) {
  char t[40];
  std::snprintf(t, sizeof t, "%.12g", time);
  const std::string frame = "<Grid Name=\"frame\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"" +
                            std::string(t) + "\"/>\n" + grids + "</Grid>\n";
  write(end_, frame + kSeriesTail + kTail);
  end_ += long(frame.size());
}

void XdmfSeries::write(long at, const std::string& text) const {
  std::FILE* f = std::fopen(path_.c_str(), "r+");
  if (!f) throw not_written(path_);
  const bool written = std::fseek(f, at, SEEK_SET) == 0 && std::fwrite(text.data(), 1, text.size(), f) == text.size();
  if (std::fclose(f) != 0 || !written) throw not_written(path_);
}

}  // namespace twogrid
