#include "liggghts_fixes/liggghts/scene_facts.h"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <fix_gravity.h>
#include <fix_insert.h>
#include <fix_mesh_surface.h>
#include <fix_particledistribution_discrete.h>
#include <fix_property_global.h>
#include <fix_template_sphere.h>
#include <fix_wall_gran.h>
#include <force.h>
#include <lammps.h>
#include <modify.h>
#include <mpi.h>
#include <neighbor.h>
#include <pair_gran.h>
#include <update.h>

#include <algorithm>
#include <cmath>

#include "cfd/grid/pi.h"
#include "liggghts_fixes/bodies/primitive_shape.h"
#include "liggghts_fixes/contacts/granular_contacts.h"

namespace twogrid {
namespace {

using namespace LAMMPS_NS;

struct Mix : FixParticledistributionDiscrete {
  static const double* weights(FixParticledistributionDiscrete& mix) { return mix.*&Mix::distweight; }
};

/// What insertion's templates say of the sizes to come: extremes, and sums of volumes and their squares.
struct TemplateSizes {
  double d_min = 0, d_max = 0, d_rough = 0;  // m; 0: unknown
  double volume = 0, mass = 0;               // expected, of one particle of each distribution, summed
  int distributions = 0;
};

TemplateSizes read_templates(LAMMPS& lammps) {
  TemplateSizes t;
  double lo = 1e300, hi = 0, cubes = 0, sixths = 0;
  const auto count = [&](FixTemplateSphere& ball, double weight) {
    const double V = ball.volexpect();
    cubes += weight * V, sixths += weight * V * V;
  };
  for (int f = 0; f < lammps.modify->nfix; ++f)
    if (auto* mix = dynamic_cast<FixParticledistributionDiscrete*>(lammps.modify->fix[f])) {
      t.volume += mix->vol_expect(), t.mass += mix->mass_expect();
      ++t.distributions;
      for (int i = 0; i < mix->n_particletemplates(); ++i) count(*mix->get_template(i), Mix::weights(*mix)[i]);
    }
  if (t.distributions == 0)
    for (int f = 0; f < lammps.modify->nfix; ++f)
      if (auto* ball = dynamic_cast<FixTemplateSphere*>(lammps.modify->fix[f])) {
        t.volume += ball->volexpect(), t.mass += ball->massexpect();
        ++t.distributions;
        count(*ball, 1);
      }
  for (int f = 0; f < lammps.modify->nfix; ++f)
    for (int type = 1; type <= lammps.atom->ntypes; ++type) {
      const double a = lammps.modify->fix[f]->min_rad(type), b = lammps.modify->fix[f]->max_rad(type);
      if (a > 0) lo = std::min(lo, a);
      if (b > 0) hi = std::max(hi, b);
    }
  if (hi > 0) t.d_min = 2 * std::min(lo, hi), t.d_max = 2 * hi;
  if (cubes > 0) t.d_rough = std::min(std::cbrt(6 / kPi * sixths / cubes), t.d_max);
  return t;
}

bool inserts(LAMMPS& lammps) {
  for (int f = 0; f < lammps.modify->nfix; ++f)
    if (dynamic_cast<FixInsert*>(lammps.modify->fix[f])) return true;
  return false;
}

void read_particles(LAMMPS& lammps, int groupbit, SceneFacts& facts) {
  const Atom& atom = *lammps.atom;
  double sum[5] = {0, 0, 0, 0, 0};       // number, diameters, mass, volume, its square
  double extreme[2] = {-1e300, -1e300};  // -smallest, largest diameter
  for (int i = 0; i < atom.nlocal; ++i) {
    if (!(atom.mask[i] & groupbit)) continue;
    const double d = 2 * atom.radius[i], V = kPi / 6 * d * d * d;
    sum[0] += 1, sum[1] += d, sum[2] += atom.rmass[i], sum[3] += V, sum[4] += V * V;
    extreme[0] = std::max(extreme[0], -d), extreme[1] = std::max(extreme[1], d);
  }
  MPI_Allreduce(MPI_IN_PLACE, sum, 5, MPI_DOUBLE, MPI_SUM, lammps.world);
  MPI_Allreduce(MPI_IN_PLACE, extreme, 2, MPI_DOUBLE, MPI_MAX, lammps.world);
  facts.particles = std::llround(sum[0]);
  long long all = atom.nlocal;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_LONG_LONG, MPI_SUM, lammps.world);
  facts.others = all - facts.particles;
  const TemplateSizes t = read_templates(lammps);
  if (facts.particles > 0) {
    facts.d_mean = sum[1] / sum[0];
    facts.d_min = -extreme[0];
    facts.d_max = extreme[1];
    facts.density = sum[2] / sum[3];
    facts.d_rough = std::cbrt(6 / kPi * sum[4] / sum[3]), facts.d_most = facts.d_max;
    if (inserts(lammps))
      facts.d_rough = std::max(facts.d_rough, t.d_rough), facts.d_most = std::max(facts.d_most, t.d_max);
    return;
  }
  // None yet: sizes and densities of insertion's templates are known, as expected values of what will be inserted.
  if (!(t.d_max > 0)) return;
  facts.sizes_of_templates = true;
  facts.d_min = t.d_min, facts.d_max = facts.d_most = t.d_max;
  facts.d_rough = t.d_rough > 0 ? t.d_rough : t.d_max;
  facts.d_mean = 0.5 * (facts.d_min + facts.d_max);
  if (t.volume > 0 && t.mass > 0) {
    facts.density = t.mass / t.volume;
    facts.d_mean = std::clamp(std::cbrt(6 / kPi * t.volume / t.distributions), facts.d_min, facts.d_max);
  }
}

struct Gravity : FixGravity {
  static bool follows_variable(FixGravity& fix) { return fix.*&Gravity::varflag != 0; }
};
bool follows_variable(FixGravity& fix) {
  return Gravity::follows_variable(fix);
}

std::vector<FixGravity*> gravity_fixes(LAMMPS& lammps) {
  std::vector<FixGravity*> found;
  for (int f = 0; f < lammps.modify->nfix; ++f)
    if (auto* gravity = dynamic_cast<FixGravity*>(lammps.modify->fix[f])) found.push_back(gravity);
  return found;
}

/// The mean over the particles of the group; where there are none yet, of fixes for group all.
void read_gravity(LAMMPS& lammps, int groupbit, SceneFacts& facts) {
  const Atom& atom = *lammps.atom;
  for (const Weight& weight : find_weights(lammps, false)) {
    long long in = 0;
    for (int i = 0; i < atom.nlocal; ++i) in += (atom.mask[i] & groupbit) && (atom.mask[i] & weight.group);
    MPI_Allreduce(MPI_IN_PLACE, &in, 1, MPI_LONG_LONG, MPI_SUM, lammps.world);
    const double share = facts.particles > 0 ? double(in) / double(facts.particles) : weight.group == ~0;
    for (int d = 0; d < 3; ++d) facts.gravity[d] += share * weight.g[d];
    facts.weights_differ |= facts.particles > 0 && in > 0 && in < facts.particles;
  }
  facts.gravity_varies = weights_vary(lammps);
}

void read_walls(LAMMPS& lammps, SceneFacts& facts) {
  const Domain& domain = *lammps.domain;
  for (int f = 0; f < lammps.modify->nfix; ++f) {
    auto* wall = dynamic_cast<FixWallGran*>(lammps.modify->fix[f]);
    if (!wall) continue;
    if (wall->is_mesh_wall()) {
      for (int m = 0; m < wall->n_meshes(); ++m) {
        WallFacts mesh;
        mesh.kind = WallFacts::Kind::kMesh;
        mesh.id = wall->mesh_list()[m]->id;
        mesh.wall = wall->id;
        BoundingBox box = wall->mesh_list()[m]->triMesh()->getGlobalBoundingBox();
        double lo[3], hi[3];
        box.getBoxBounds(lo, hi);
        for (int d = 0; d < 3; ++d) mesh.bounds[2 * d] = lo[d], mesh.bounds[2 * d + 1] = hi[d];
        facts.walls.push_back(mesh);
      }
      continue;
    }
    if (!wall->primitiveWall()) continue;
    const Primitive p = primitive_of(*wall);
    WallFacts primitive;
    primitive.id = primitive.wall = wall->id;
    if (p.cylinder) {
      primitive.kind = WallFacts::Kind::kCylinder;
      primitive.axis = p.axis, primitive.radius = p.value[0];
      for (int d = 0, q = 1; d < 3; ++d) {
        primitive.bounds[2 * d] = d == p.axis ? domain.boxlo[d] : p.value[q] - p.value[0];
        primitive.bounds[2 * d + 1] = d == p.axis ? domain.boxhi[d] : p.value[q] + p.value[0];
        q += d != p.axis;
      }
    } else {
      primitive.kind = WallFacts::Kind::kPlane;
      primitive.axis = p.axis, primitive.position = p.value[0];
    }
    facts.walls.push_back(primitive);
  }
}

double property(LAMMPS& lammps, const char* name, const char* style, int types) {
  Fix* fix = lammps.modify->find_fix_property(name, "property/global", style, types, 0, "twogrid", false);
  auto* values = dynamic_cast<FixPropertyGlobal*>(fix);
  if (!values) return 0;
  return std::string(style) == "scalar"            ? values->compute_scalar()
         : std::string(style) == "peratomtypepair" ? values->compute_array(0, 0)
                                                   : values->compute_vector(0);
}

/// Duration of a head-on contact of two mean particles, first atom type: linear spring pi sqrt(m*/k_n); Hertz (1882)
/// 2.87 (m*^2 / (R* E*^2 V))^(1/5).
void read_contact_time(LAMMPS& lammps, SceneFacts& facts) {
  if (facts.d_mean <= 0 || facts.density <= 0) return;
  const int types = lammps.atom->ntypes;
  const double R = 0.25 * facts.d_mean, m = 0.5 * facts.density * kPi / 6 * std::pow(facts.d_mean, 3);
  const double k = property(lammps, "kn", "peratomtypepair", types);
  if (k > 0) {
    facts.contact_time = kPi * std::sqrt(m / k);
    facts.contact_time_from = "kn of type 1";
    return;
  }
  const double Y = property(lammps, "youngsModulus", "peratomtype", types);
  const double nu = property(lammps, "poissonsRatio", "peratomtype", types);
  if (Y <= 0) return;
  const double E = Y / (2 * (1 - nu * nu));
  double V = property(lammps, "characteristicVelocity", "scalar", 0);
  const bool characteristic = V > 0;
  if (!characteristic) V = 1;
  facts.contact_time = 2.87 * std::pow(m * m / (R * E * E * V), 0.2);
  facts.contact_time_from = characteristic ? "Hertz at the characteristic velocity" : "Hertz at 1 m/s";
}

/// LIGGGHTS' model hooke: k_n = 16/15 sqrt(R*) E* (15 m* V^2/(16 sqrt(R*) E*))^(1/5), V the characteristic velocity.
void read_equal_stiffness(LAMMPS& lammps, SceneFacts& facts) {
  auto* pair = dynamic_cast<PairGran*>(lammps.force->pair);
  if (!pair || !pair->contact_match("normal", "hooke") || facts.d_mean <= 0 || facts.density <= 0) return;
  const int types = lammps.atom->ntypes;
  const double Y = property(lammps, "youngsModulus", "peratomtype", types);
  const double nu = property(lammps, "poissonsRatio", "peratomtype", types);
  const double V = property(lammps, "characteristicVelocity", "scalar", 0);
  if (Y <= 0 || V <= 0) return;
  const double R = 0.25 * facts.d_mean, m = 0.5 * facts.density * kPi / 6 * std::pow(facts.d_mean, 3);
  const double E = Y / (2 * (1 - nu * nu)), root = std::sqrt(R) * E;
  facts.equal_kn = 16.0 / 15 * root * std::pow(15 * m * V * V / (16 * root), 0.2);
}

}  // namespace

std::vector<Weight> find_weights(LAMMPS& lammps, bool running) {
  std::vector<Weight> weights;
  for (FixGravity* fix : gravity_fixes(lammps)) {
    if (!running && follows_variable(*fix)) continue;
    Weight weight{fix->groupbit & 1 ? ~0 : fix->groupbit, {0, 0, 0}};  // the first bit is group all's
    fix->get_gravity(weight.g.data());
    weights.push_back(weight);
  }
  return weights;
}

bool weights_vary(LAMMPS& lammps) {
  const std::vector<FixGravity*> fixes = gravity_fixes(lammps);
  return std::any_of(fixes.begin(), fixes.end(), [](FixGravity* fix) { return follows_variable(*fix); });
}

SceneFacts scene_facts(LAMMPS& lammps, int groupbit) {
  SceneFacts facts;
  read_particles(lammps, groupbit, facts);
  read_gravity(lammps, groupbit, facts);
  read_walls(lammps, facts);
  facts.dem_dt = lammps.update->dt;
  facts.skin = lammps.neighbor->skin;
  read_contact_time(lammps, facts);
  read_equal_stiffness(lammps, facts);
  facts.contacts = contacts_text(lammps);
  facts.ranks = lammps.comm->nprocs;
  for (int d = 0; d < 3; ++d) facts.bricks[d] = lammps.comm->procgrid[d];
  return facts;
}

}  // namespace twogrid
