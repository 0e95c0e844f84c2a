#include "liggghts_fixes/report/memory_need.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

double product(const Int3& n) {
  return double(n[0]) * n[1] * n[2];
}

/// The first number of a file; infinite where there is none.
double number_in(const std::string& file) {
  std::ifstream in(file);
  double value = 0;
  return in >> value ? value : INFINITY;
}

/// What control groups leave a batch job or container.
double free_in_groups() {
  double free = INFINITY;
  std::vector<std::string> folders{"/sys/fs/cgroup"};
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);)
    if (line.rfind("0::/", 0) == 0)  // this group and all above it
      for (std::string path = line.substr(3); path.size() > 1; path.erase(path.find_last_of('/')))
        folders.push_back("/sys/fs/cgroup" + path);
  for (const std::string& f : folders)
    free = std::min(free, number_in(f + "/memory.max") - std::min(number_in(f + "/memory.current"), 1e300));
  const std::string old = "/sys/fs/cgroup/memory/memory.";
  return std::min(free, number_in(old + "limit_in_bytes") - std::min(number_in(old + "usage_in_bytes"), 1e300));
}

double free_on_machine() {
  std::ifstream in("/proc/meminfo");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    double kilobytes = 0;
    if (words >> name >> kilobytes && name == "MemAvailable:") return 1024 * kilobytes;
  }
  return INFINITY;
}

/// What this process may still map (ulimit -v).
double free_in_process() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return INFINITY;
  const double pages = number_in("/proc/self/statm");
  return double(limit.rlim_cur) - (std::isfinite(pages) ? 4096 * pages : 0.0);
}

}  // namespace

double bytes_needed(const Settings& s, const Int3& bricks, std::size_t bodies) {
  constexpr double kDouble = sizeof(double), kMultigrid = 36 * 1.55, kParticleCell = 650, kCutSurface = 7000;
  const double cells = product(s.fine);
  double with_halo = cells;
  for (int d = 0; d < 3; ++d)
    if (s.fine[d] > 1) with_halo *= 1 + std::min(4.0 * bricks[d] / s.fine[d], 4.0);
  const bool A = s.formulation == Formulation::kA, checks = s.accuracy > 0;
  // fields of the fluid 20, void fraction of the interval 4, mean velocity 3
  const double fields = 27 + (A ? 6 : 0) + (checks ? 43 : 0) + (s.fluid.implicit_viscosity == Choice::kOn ? 7 : 0);
  double bytes = with_halo * (kDouble * fields + 3) + cells * (kDouble * 5 + kMultigrid);
  // Open shares and what is made of them 18 fields, inertia share and eps of the open space 4, friction 3; bits of links.
  // Lists of the faces that are cut: measured for a cylinder across the box, an estimate for others.
  if (bodies > 0) bytes += with_halo * (kDouble * 25 + 3) + kCutSurface * std::cbrt(cells * cells);
  double coarse = cells;
  for (int r : s.ratio) coarse /= r;
  bytes += coarse * kParticleCell;
  if (s.output.every > 0) bytes += cells * kDouble * 3;
  if (s.output.average_from >= 0 && !s.output.file.empty()) bytes += kDouble * (13 * cells + 212 * coarse);
  // Facets as of a body of the domain's size; a fit takes some 2.5 kB.
  if (s.fluid.wall_stress)
    bytes += 10e3 * std::cbrt(cells * cells) + (s.output.average_from >= 0 ? 4 * kDouble * cells : 0);
  return bytes;
}

double bytes_free() {
  return std::min(free_on_machine(), free_in_groups());
}

std::string bytes_text(double bytes) {
  static const char* const kUnits[] = {"B", "kB", "MB", "GB", "TB", "PB"};
  int unit = 0;
  while (bytes >= 999.5 && unit < 5) bytes /= 1000, ++unit;
  std::ostringstream out;
  out.precision(bytes < 99.5 ? 2 : 3);
  out << bytes << " " << kUnits[unit];
  return out.str();
}

std::string check_memory(MPI_Comm comm, const Settings& s, const Int3& bricks, double most_cells, std::size_t bodies) {
  int ranks = 1, ranks_here = 1;
  MPI_Comm_size(comm, &ranks);
  MPI_Comm here;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
  MPI_Comm_size(here, &ranks_here);
  MPI_Comm_free(&here);
  const double cells = product(s.fine), needed = bytes_needed(s, bricks, bodies), of_a_rank = needed / ranks;
  // Of this rank: what is free for it, as its machine's ranks take all the same.
  const double mine = std::min(bytes_free() / ranks_here, free_in_process());
  double least = mine;
  MPI_Allreduce(&mine, &least, 1, MPI_DOUBLE, MPI_MIN, comm);
  const std::string fine = text(s.fine[0]) + " " + text(s.fine[1]) + " " + text(s.fine[2]);
  const std::string need = brief(cells) + " fine cells need about " + bytes_text(needed);
  if (cells > most_cells)
    refuse("fine", fine + ": " + brief(cells) + " cells",
           "at most " + text(most_cells) + ", which is what this PETSc can number");
  if (of_a_rank > least)
    refuse("fine", fine + ": " + need + ", " + bytes_text(of_a_rank) + " a rank",
           "what fits into the " + bytes_text(least) + " that are free for a rank: fewer fine cells, or more machines");
  return "twogrid: " + need + " of memory" + (ranks > 1 ? ", " + bytes_text(of_a_rank) + " a rank" : "") +
         (std::isfinite(least) ? "; free: " + bytes_text(least) + (ranks > 1 ? " a rank" : "") : "") + "\n";
}

}  // namespace twogrid
