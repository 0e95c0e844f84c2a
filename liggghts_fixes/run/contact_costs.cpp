#include "liggghts_fixes/run/contact_costs.h"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <force.h>
#include <lammps.h>
#include <mpi.h>
#include <neigh_list.h>
#include <pair.h>
#include <update.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "coupling/control/stopwatch.h"
#include "liggghts_fixes/script/words.h"
#include "liggghts_fixes/style_registry.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

std::string line_of(const Command& c) {
  std::string line;
  for (const std::string& w : c)
    line += (line.empty() ? "" : " ") + (w.find(' ') == std::string::npos && !w.empty() ? w : "\"" + w + "\"");
  return line;
}

bool is_law(const Command& c) {
  static const std::set<std::string> kNames{"units",       "atom_style",     "newton",
                                            "communicate", "soft_particles", "hard_particles",
                                            "pair_style",  "pair_coeff",     "timestep"};
  return kNames.count(c[0]) > 0 || (c[0] == "fix" && c.size() > 3 && c[3].rfind("property/global", 0) == 0);
}

bool before_box(const Command& c) {
  return c[0] == "units" || c[0] == "atom_style" || c[0] == "newton" || c[0] == "communicate";
}

/// Diameters between the spheres of a lattice that has as many of them as a packing, 0.6 of the volume: thrown about
/// at random, each touches 2.4 others on average, each contact counted once.
constexpr double kPacked = 0.956;

/// Each rank's own, anywhere in its part of the box.
void throw_about(LAMMPS& lammps) {
  std::mt19937 random(1);
  for (int d = 0; d < 3; ++d) {
    std::uniform_real_distribution<double> place(lammps.domain->sublo[d], lammps.domain->subhi[d]);
    for (int i = 0; i < lammps.atom->nlocal; ++i) lammps.atom->x[i][d] = place(random);
  }
}

struct SphereCost {
  double seconds = 0;   ///< CPU s of a particle's step
  double contacts = 0;  ///< a particle
  double build = 0;     ///< CPU s of a particle's new neighbours
};

/// CPU s of a DEM step, the least of some tries.
double least_step(LAMMPS& lammps) {
  constexpr int kSteps = 30;
  double least = std::numeric_limits<double>::infinity(), begin = 0;
  for (int i = 0; i < 5; ++i) {
    stock_run(lammps, "run",
              i == 0 ? Command{std::to_string(kSteps)} : Command{std::to_string(kSteps), "pre", "no", "post", "no"});
    const double end = cpu_seconds();
    if (i > 0) least = std::min(least, end - begin);
    begin = end;
  }
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MAX, lammps.world);
  return least / kSteps;
}

/// Of spheres in a lattice of this spacing, or at random with as many to the volume.
SphereCost sphere_cost(LAMMPS& lammps, const std::vector<Command>& commands, const PlannedSpheres& s, double spacing,
                       bool at_random, const std::function<void(const std::string&)>& execute) {
  constexpr double kFewest = 12 * 12 * 12, kMost = 40 * 40 * 40;  // a rank
  const double ranks = lammps.comm->nprocs;
  const int side = int(std::lround(std::cbrt(ranks * std::clamp(s.number / ranks, kFewest, kMost))));
  const std::string length = text(side * spacing);
  // At random they overlap deeply: so heavy that they don't move.
  const double density = s.density * (at_random ? 1e9 : 1);
  execute("clear");
  for (const Command& c : commands)
    if (before_box(c)) execute(line_of(c));
  for (const std::string& line : {std::string("boundary p p p"), std::string("processors * * *"),
                                  "region plan_box block 0 " + length + " 0 " + length + " 0 " + length + " units box",
                                  "create_box " + std::to_string(s.types) + " plan_box",
                                  "neighbor " + text(s.skin) + " bin", std::string("neigh_modify delay 0")})
    execute(line);
  for (const Command& c : commands)
    if (is_law(c) && !before_box(c)) execute(line_of(c));
  for (const std::string& line : {"lattice sc " + text(spacing), std::string("create_atoms 1 box"),
                                  "set group all diameter " + text(s.diameter) + " density " + text(density),
                                  std::string("fix plan_motion all nve/sphere"),
                                  std::string("thermo_style custom step"), std::string("thermo 1000000")})
    execute(line);
  if (at_random) throw_about(lammps);
  const double step = least_step(lammps);
  double build = 0;
  if (at_random) {
    execute("neigh_modify every 1 delay 0 check no");
    build = std::max(0.0, least_step(lammps) - step);
  }
  double contacts = count_contacts(lammps);
  MPI_Allreduce(MPI_IN_PLACE, &contacts, 1, MPI_DOUBLE, MPI_SUM, lammps.world);
  const double number = double(side) * side * side;
  return {step * ranks / number, contacts / number, build * ranks / number};
}

}  // namespace

ContactCosts contact_costs(LAMMPS& lammps, const std::vector<Command>& commands, const PlannedSpheres& spheres,
                           const std::function<void(const std::string&)>& execute) {
  if (!(spheres.diameter > 0 && spheres.density > 0 && spheres.skin > 0)) return {};
  if (std::none_of(commands.begin(), commands.end(),
                   [](const Command& c) { return c[0] == "pair_style" && c.size() > 1 && c[1] == "gran"; }))
    return {};
  const SphereCost touching = sphere_cost(lammps, commands, spheres, kPacked * spheres.diameter, true, execute);
  const SphereCost apart =
      sphere_cost(lammps, commands, spheres, spheres.diameter + 0.5 * spheres.skin, false, execute);
  if (!(touching.contacts > 0)) return {apart.seconds, 0, 0};
  return {apart.seconds, std::max(0.0, touching.seconds - apart.seconds) / touching.contacts, touching.build};
}

double count_contacts(LAMMPS& lammps) {
  double count = 0;
  const Atom& atom = *lammps.atom;
  const NeighList* list = lammps.force->pair ? lammps.force->pair->list : nullptr;
  if (!list || !atom.radius) return count;
  for (int ii = 0; ii < list->inum; ++ii) {
    const int i = list->ilist[ii];
    for (int jj = 0; jj < list->numneigh[i]; ++jj) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      double r2 = 0;
      for (int d = 0; d < 3; ++d) r2 += (atom.x[i][d] - atom.x[j][d]) * (atom.x[i][d] - atom.x[j][d]);
      const double reach = atom.radius[i] + atom.radius[j];
      count += r2 < reach * reach;
    }
  }
  return count;
}

}  // namespace twogrid
