#include "liggghts_fixes/liggghts/run_record.h"

#include <lammps.h>
#include <sys/stat.h>
#include <unistd.h>
#include <universe.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "liggghts_fixes/run/petsc_session.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

std::string command_line_text() {
  std::ifstream in("/proc/self/cmdline");
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::replace(text.begin(), text.end(), '\0', ' ');
  return text;
}

/// The text of the script LIGGGHTS is reading now, without moving its place in it. Rank 0.
std::string script_text(FILE* infile) {
  struct stat status = {};
  if (!infile || fstat(fileno(infile), &status) != 0 || !S_ISREG(status.st_mode)) return "(not read from a file)";
  std::string script(std::size_t(status.st_size), '\0');
  const ssize_t n = pread(fileno(infile), script.data(), script.size(), 0);
  script.resize(n > 0 ? std::size_t(n) : 0);
  return script;
}

}  // namespace

Record run_record(LAMMPS& lammps) {
  Record record;
  record.input_text = script_text(lammps.infile);
  record.command_line = command_line_text();
  record.versions = {{"LIGGGHTS", lammps.universe->version}, {"PETSc", petsc_version()}};
  return record;
}

}  // namespace twogrid
