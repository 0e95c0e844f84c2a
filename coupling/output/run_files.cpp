#include "coupling/output/run_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "coupling/output/hdf5_tools.h"
#include "coupling/output/held_writes.h"

namespace twogrid {

namespace {

using Kind = FoundFile::Kind;

bool is_there(const std::string& path) {
  struct stat s;
  return stat(path.c_str(), &s) == 0;
}

std::string ending(const std::string& file) {
  return file.substr(stem(file).size());
}

std::vector<std::string> members(hid_t file, const char* group) {
  std::vector<std::string> names;
  if (H5Lexists(file, group, H5P_DEFAULT) <= 0) return names;
  Handle g(H5Gopen2(file, group, H5P_DEFAULT), H5Gclose);
  if (g < 0) throw std::runtime_error(group);
  const herr_t good = H5Literate(
      g, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
        static_cast<std::vector<std::string>*>(to)->push_back(name);
        return 0;
      },
      &names);
  if (good < 0) throw std::runtime_error(group);
  return names;
}

double number(hid_t file, const std::string& path) {
  Handle set(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
  double value = 0;
  if (set < 0 || H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) < 0)
    throw std::runtime_error(path);
  return value;
}

double number_attribute(hid_t file, const std::string& object, const std::string& name) {
  Handle a(H5Aopen_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  double value = 0;
  if (a < 0 || H5Aread(a, H5T_NATIVE_DOUBLE, &value) < 0) throw std::runtime_error(object);
  return value;
}

/// Throws where something of it can't be read.
XdmfFrame read_frame(hid_t file, const std::string& h5, const std::string& name, const std::array<int, 3>& n) {
  XdmfFrame f;
  f.h5 = h5, f.name = name, f.n = n;
  const std::string fluid = "/fluid/" + name, particles = "/particles/" + name;
  f.time = number(file, fluid + "/time"), f.step = number(file, fluid + "/step");
  std::vector<std::string> there = members(file, fluid.c_str());
  for (const std::string& field : there) {
    if (field == "time" || field == "step" || field == "faces" || field == "bodies") continue;
    const auto extent = extent_of(file, fluid + "/" + field);
    if (extent.size() < 3) throw std::runtime_error(fluid + "/" + field);
    f.cells.push_back({field, "", extent.size() == 4 ? 3 : 1, false});
  }
  if (H5Lexists(file, "/grid/theta", H5P_DEFAULT) > 0)
    for (const XdmfField& field : open_fields("/grid")) f.cells.push_back(field);
  // In the order of a frame that is written: u, p, eps, then those of models.
  std::stable_sort(f.cells.begin(), f.cells.end(), [](const XdmfField& a, const XdmfField& b) {
    const auto turn = [](const std::string& s) { return s == "u" ? 0 : s == "p" ? 1 : s == "eps" ? 2 : 3; };
    return turn(a.name) < turn(b.name);
  });
  if (H5Lexists(file, "/walls", H5P_DEFAULT) > 0 && H5Lexists(file, ("/walls/" + name).c_str(), H5P_DEFAULT) > 0) {
    const auto rows = [&](const char* set) {
      const auto extent = extent_of(file, std::string("/grid/walls/") + set);
      if (extent.empty()) throw std::runtime_error(std::string("/grid/walls/") + set);
      return (long long)extent[0];
    };
    f.walls = {rows("body"), rows("points"), rows("polygons")};
  }
  there = members(file, particles.c_str());
  if (there.empty()) return f;
  const auto rows = extent_of(file, particles + "/position");
  f.particles = rows.empty() ? 0 : (long long)rows[0];
  if (f.particles == 0) return f;
  for (const char* p : {"velocity", "radius", "id", "force", "drag", "pressure_force", "eps"})
    if (std::find(there.begin(), there.end(), p) != there.end())
      f.points.push_back({p, "", extent_of(file, particles + "/" + p).size() == 2 ? 3 : 1, p == std::string("id")});
  return f;
}

void read_output(hid_t file, const std::string& path, FoundFile& found) {
  const auto whole3 = [&](const char* name, std::array<int, 3>& to) {
    const std::vector<int> v = whole_attribute_of(file, "/record", name);
    if (v.size() != 3) throw std::runtime_error("/record");
    std::copy(v.begin(), v.end(), to.begin());
  };
  whole3("fine", found.fine), whole3("ratio", found.ratio);
  for (const std::string& name : members(file, "/record")) {
    int leg = 0;
    if (std::sscanf(name.c_str(), "leg_%d", &leg) != 1) continue;
    const double from = number_attribute(file, "/record/" + name, "checkpoint_step");
    found.from = found.legs == 0 ? from : std::min(found.from, from);
    found.legs = std::max(found.legs, leg);
  }
  for (const std::string& name : members(file, "/fluid"))
    found.frames.push_back(read_frame(file, name_in_directory(path), name, found.fine));
  found.means = H5Lexists(file, "/average", H5P_DEFAULT) > 0;
}

std::runtime_error refusal(const std::string& path, const std::string& what, bool goes_on) {
  return std::runtime_error("output file: found '" + path + "', which is there already (" + what +
                            "), wanted a name that is free: " + "give another one, move the file away, " +
                            (goes_on ? "" : "go on from a checkpoint of its run, ") +
                            "or say 'fix_modify ID output overwrite yes' to have it replaced");
}

/// bed.h5 -> bed.old1.h5
std::string put_aside(const std::string& path) {
  std::string other;
  for (int i = 1; other.empty() || is_there(other); ++i) other = stem(path) + ".old" + std::to_string(i) + ending(path);
  if (std::rename(path.c_str(), other.c_str()) != 0) throw refusal(path, "it could not be put aside", true);
  return "the output file " + path + " of a run that left no checkpoint of its fluid is now " + other;
}

}  // namespace

std::string stem(const std::string& file) {
  const auto slash = file.find_last_of('/'), dot = file.find_last_of('.');
  const bool has_ending = dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
  return has_ending ? file.substr(0, dot) : file;
}

std::string name_of_leg(const std::string& file, int leg) {
  return leg <= 1 ? file : stem(file) + "." + std::to_string(leg) + ending(file);
}

std::string name_in_directory(const std::string& file) {
  const auto slash = file.find_last_of('/');
  return slash == std::string::npos ? file : file.substr(slash + 1);
}

FoundFile look_at(const std::string& path) {
  FoundFile found;
  struct stat s;
  if (stat(path.c_str(), &s) != 0) return found;
  found.kind = Kind::kOther, found.what = "no output file of twogrid";
  if (!S_ISREG(s.st_mode))
    throw std::runtime_error("the file '" + path +
                             "' cannot be written (it is not a regular file); give the path of a file in a directory "
                             "that exists and may be written (fix_modify ID output file)");
  Quiet quiet;
  Handle file(HeldWrites::open_to_read(path), H5Fclose);
  if (file < 0) {
    found.kind = Kind::kDamaged, found.what = "no HDF5 file, or a damaged one";
    return found;
  }
  if (H5Lexists(file, "/record", H5P_DEFAULT) <= 0 || text_attribute_of(file, "/record", "program") != "twogrid")
    return found;
  found.what = "written by twogrid at " + text_attribute_of(file, "/record", "date");
  found.run = text_attribute_of(file, "/record", "run");
  found.kind = Kind::kOutput;
  try {
    read_output(file, path, found);
    found.what += ", " + std::to_string(found.frames.size()) + " frames";
  } catch (const std::exception& e) {
    found.kind = Kind::kDamaged, found.what += ", of which " + std::string(e.what()) + " can't be read";
  }
  return found;
}

WhereToWrite begin_files(const OutputSettings& settings) {
  WhereToWrite w;
  w.file = settings.file;
  const FoundFile found = look_at(settings.file);
  if (settings.overwrite) return w;
  if (settings.keep_old) {
    if (found.kind != Kind::kNone) w.sentences.push_back(put_aside(settings.file));
    return w;
  }
  if (found.kind != Kind::kNone) throw refusal(settings.file, found.what, false);
  const std::string xdmf[2] = {stem(settings.file) + ".xdmf", stem(settings.file) + "_average.xdmf"};
  const bool wanted[2] = {settings.every > 0, settings.average_from >= 0};
  for (int i = 0; i < 2; ++i)
    if (wanted[i] && is_there(xdmf[i])) throw refusal(xdmf[i], "this file would go with " + settings.file, false);
  return w;
}

WhereToWrite go_on_with_files(const OutputSettings& settings, const std::string& id, const Int3& fine,
                              const Int3& ratio, double last) {
  WhereToWrite w;
  std::vector<FoundFile> found;
  int newest = -1, free_leg = 0;  // of this run, or damaged; the first number that is free
  for (int leg = 1; leg == 1 || free_leg == 0; ++leg) {
    const std::string path = name_of_leg(settings.file, leg);
    found.push_back(look_at(path));
    FoundFile& f = found.back();
    if (f.kind == Kind::kNone && leg > 1) free_leg = leg;
    const bool ours = f.kind == Kind::kOutput && f.run == id;
    if (ours && (f.fine != fine || f.ratio != ratio)) throw refusal(path, f.what + ", on other grids", true);
    if (ours || (f.kind == Kind::kDamaged && (f.run == id || f.run.empty()))) newest = leg - 1;
  }
  if (newest < 0 && found[0].kind != Kind::kNone && !settings.overwrite)
    throw refusal(settings.file, found[0].what + ", of another run", true);
  for (const FoundFile& f : found)
    if (f.run == id) w.leg = std::max(w.leg, f.legs);
  w.leg = std::max(w.leg + 1, 2);

  const bool damaged = newest >= 0 && found[newest].kind == Kind::kDamaged;
  if (newest < 0)
    w.file = settings.file;
  else if (damaged || settings.many_legs)
    w.file = name_of_leg(settings.file, free_leg);
  else
    w.file = name_of_leg(settings.file, newest + 1), w.create = false;

  if (newest < 0 && found[0].kind == Kind::kNone)
    w.sentences.push_back("the output file " + settings.file + " is not there any more: a new one begins");
  if (damaged)
    w.sentences.push_back("the output file " + name_of_leg(settings.file, newest + 1) + " is damaged (" +
                          found[newest].what + "): it is left as it is, and the output goes on in " + w.file);
  for (int i = 0; i < int(found.size()); ++i) {
    FoundFile& f = found[i];
    if (f.kind != Kind::kOutput || f.run != id) continue;
    // What files before hold of later steps has been done once more.
    const double from = f.from;
    if (i > 0 && f.legs > 0)
      w.shown.erase(
          std::remove_if(w.shown.begin(), w.shown.end(), [from](const XdmfFrame& s) { return s.step > from; }),
          w.shown.end());
    w.shown.insert(w.shown.end(), f.frames.begin(), f.frames.end());
    if (w.create || i != newest) continue;
    w.means = f.means;
    for (const XdmfFrame& s : f.frames) s.step > last ? w.drop.push_back(s.name) : void(++w.frames);
  }
  w.shown.erase(std::remove_if(w.shown.begin(), w.shown.end(), [last](const XdmfFrame& s) { return s.step > last; }),
                w.shown.end());
  if (!w.create) {
    std::string sentence = "the output goes on in " + w.file + " after " + std::to_string(w.frames) + " frames";
    if (!w.drop.empty())
      sentence += "; " + std::to_string(w.drop.size()) + " later ones, which are written again, have been taken out";
    w.sentences.push_back(sentence);
  } else if (newest >= 0 && !damaged) {
    w.sentences.push_back("the output goes on in a new file, " + w.file);
  }
  return w;
}

}  // namespace twogrid
