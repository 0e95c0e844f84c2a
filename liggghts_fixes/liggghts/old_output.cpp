#include "liggghts_fixes/liggghts/old_output.h"

#include <dump.h>
#include <lammps.h>
#include <mpi.h>
#include <output.h>
#include <unistd.h>
#include <update.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "cfd/parallel/ranks.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// What a dump keeps for itself.
struct Inside : Dump {
  static const char* file(Dump& d) { return d.*&Inside::filename; }
  static bool one_file(Dump& d) { return d.*&Inside::multifile == 0 && d.*&Inside::multiproc == 0; }
  static int digits(Dump& d) { return d.*&Inside::padflag; }
  static void append(Dump& d) { d.*& Inside::append_flag = 1; }
};

/// Cuts a text dump before its first frame of a later step. Whether the last one that stays is of this step.
bool cut(const char* path, long long step) {
  std::FILE* f = std::fopen(path, "r");
  if (!f) return false;
  constexpr char kFrame[] = "ITEM: TIMESTEP";
  char line[4096];
  long end = -1;
  long long last = -1;
  for (long at = 0; std::fgets(line, sizeof line, f); at = std::ftell(f)) {
    if (std::strncmp(line, kFrame, sizeof kFrame - 1) != 0) continue;
    if (!std::fgets(line, sizeof line, f) || std::atoll(line) > step) {
      end = at;
      break;
    }
    last = std::atoll(line);
  }
  std::fclose(f);
  if (end >= 0 && truncate(path, end) != 0) return false;
  return last == step;
}

}  // namespace

void go_on_with_dumps(LAMMPS& lammps) {
  Output& output = *lammps.output;
  const long long step = lammps.update->ntimestep;
  for (int i = 0; i < output.ndump; ++i) {
    Dump& dump = *output.dump[i];
    int there = 0;
    if (rank_of(lammps.world) == 0) {
      if (Inside::one_file(dump)) {
        there = cut(Inside::file(dump), step);
      } else {
        std::string name = Inside::file(dump);
        const std::size_t star = name.find('*');
        std::string number = std::to_string(step);
        number.insert(0, std::size_t(std::max(0, Inside::digits(dump) - int(number.size()))), '0');
        if (star != std::string::npos) name.replace(star, 1, number);
        there = access(name.c_str(), F_OK) == 0;
      }
    }
    MPI_Bcast(&there, 1, MPI_INT, 0, lammps.world);
    if (Inside::one_file(dump)) Inside::append(dump);
    if (there) output.last_dump[i] = step;
  }
}

}  // namespace twogrid
