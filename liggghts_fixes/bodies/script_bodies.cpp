#include "liggghts_fixes/bodies/script_bodies.h"

#include <atom.h>
#include <domain.h>
#include <fix_mesh_surface.h>
#include <fix_wall_gran.h>
#include <lammps.h>
#include <modify.h>
#include <region.h>
#include <region_intersect.h>
#include <region_union.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "cfd/bodies/triangle_set.h"
#include "cfd/grid/pi.h"
#include "liggghts_fixes/bodies/mesh_triangles.h"
#include "liggghts_fixes/bodies/primitive_shape.h"
#include "liggghts_fixes/bodies/region_shape.h"
#include "liggghts_fixes/bodies/surface_motion.h"
#include "liggghts_fixes/private_member.h"
#include "liggghts_fixes/script/words.h"

namespace {
using LAMMPS_NS::RegIntersect;
using LAMMPS_NS::RegUnion;
PRIVATE_MEMBER(UnionCount, RegUnion, int, nregion);
PRIVATE_MEMBER(UnionList, RegUnion, int*, list);
PRIVATE_MEMBER(IntersectCount, RegIntersect, int, nregion);
PRIVATE_MEMBER(IntersectList, RegIntersect, int*, list);
}  // namespace

namespace twogrid {
namespace {

using namespace LAMMPS_NS;

/// FNV-1a.
void add(std::uint64_t& print, const void* bytes, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) print = (print ^ static_cast<const unsigned char*>(bytes)[i]) * 1099511628211u;
}

Fix* find_fix(LAMMPS& lammps, const std::string& id) {
  const int f = lammps.modify->find_fix(id.c_str());
  return f < 0 ? nullptr : lammps.modify->fix[f];
}

std::string style_of(const Fix* fix) {
  return fix ? "a fix " + std::string(fix->style) : "no fix of that id";
}

/// A region's parts, down to those that have none.
void leaves(LAMMPS& lammps, Region& region, std::vector<Region*>& found) {
  Region** const all = lammps.domain->regions;
  if (auto* u = dynamic_cast<RegUnion*>(&region)) {
    for (int i = 0; i < u->*member(UnionCount()); ++i) leaves(lammps, *all[(u->*member(UnionList()))[i]], found);
  } else if (auto* s = dynamic_cast<RegIntersect*>(&region)) {
    for (int i = 0; i < s->*member(IntersectCount()); ++i)
      leaves(lammps, *all[(s->*member(IntersectList()))[i]], found);
  } else {
    found.push_back(&region);
  }
}

/// One that stays as it is.
Region& find_region(LAMMPS& lammps, const std::string& name, const std::string& keyword) {
  std::string id = name;
  const int r = lammps.domain->find_region(id.data());
  if (r < 0) refuse(keyword, name + ", and no region of that id", "the id of a region");
  Region& region = *lammps.domain->regions[r];
  if (region.varshape || region.dynamic_check())
    refuse(keyword, name + ", which moves or changes its shape", "a region at rest (no move, rotate or v_NAME)");
  return region;
}

Region& region_of(LAMMPS& lammps, const BodyNames& names) {
  const std::string keyword = solid_keyword(names) + " region";
  Region& region = find_region(lammps, names.id, keyword);
  std::vector<Region*> parts;
  leaves(lammps, region, parts);
  for (Region* part : parts)
    if (std::strcmp(part->style, "mesh/tet") == 0)
      refuse(keyword, names.id + " with a part of style mesh/tet, of which each rank knows its own piece only",
             "another style, or its surface as 'fix mesh/surface' and 'solid " + names.name + " mesh FIXID'");
  return region;
}

FixMeshSurface& mesh_of(LAMMPS& lammps, const BodyNames& names) {
  const std::string keyword = solid_keyword(names) + " mesh";
  Fix* const fix = find_fix(lammps, names.id);
  auto* mesh = dynamic_cast<FixMeshSurface*>(fix);
  if (!mesh)
    refuse(keyword, names.id + ", " + style_of(fix),
           "the id of a fix mesh/surface, before the first run with the fluid");
  return *mesh;
}

FixWallGran& wall_of(LAMMPS& lammps, const BodyNames& names) {
  Fix* const fix = find_fix(lammps, names.id);
  auto* wall = dynamic_cast<FixWallGran*>(fix);
  if (!wall)
    refuse(solid_keyword(names) + " wall", names.id + ", " + style_of(fix),
           "the id of a fix wall/gran, before the first run with the fluid");
  return *wall;
}

/// A region without a bounding box that a periodic side cuts must go on at the other one; of others there are images.
void check_periodic(const BodyNames& names, const SolidShape& shape, const FineGrid& grid) {
  Vec3 from, to;
  shape.bounds(from, to);
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    if (!a.periodic() || from[d] <= to[d]) continue;
    const Axis &e = grid.axis[(d + 1) % 3], &f = grid.axis[(d + 2) % 3];
    for (int j = 0; j <= f.n(); ++j)
      for (int i = 0; i <= e.n(); ++i) {
        Vec3 lo, hi;
        lo[d] = a.lo(), hi[d] = a.hi();
        lo[(d + 1) % 3] = hi[(d + 1) % 3] = e.node(i), lo[(d + 2) % 3] = hi[(d + 2) % 3] = f.node(j);
        if (shape.side(lo) != shape.side(hi))
          refuse(
              solid_keyword(names),
              "a shape that is cut off by the periodic side " + std::string(1, "xyz"[d]) + " = " + text(a.lo()) +
                  " and doesn't go on at " + text(a.hi()),
              "one that ends inside the box or goes through it, or the same with 'side in', which is continued there");
      }
  }
}

/// Directions of one cell left out (m).
double widest_cell(const FineGrid& grid) {
  double h = 0;
  for (const Axis& a : grid.axis)
    for (int i = 0; i < a.n() && a.n() > 1; ++i) h = std::max(h, a.width(i));
  return h;
}

/// checkpoints: the run writes them by itself.
Body mesh_body(LAMMPS& lammps, const BodyNames& names, const std::vector<FixMeshSurface*>& meshes, const FineGrid& grid,
               bool checkpoints, std::uint64_t* print) {
  std::vector<Triangle> all;
  std::vector<SurfaceMotion> motions;
  bool turned = false;
  for (FixMeshSurface* mesh : meshes) {
    const std::vector<Triangle> some = mesh_triangles(*mesh, lammps.world);
    const FeltMotion moved = mover_motion(lammps, *mesh, some);
    if (!moved.why.empty())
      refuse(
          solid_keyword(names), "mesh " + std::string(mesh->id) + " " + moved.why,
          "a mesh that stays where it is, at rest or turned by one 'fix move/mesh ... rotate' about the axis about "
          "which it is round: bodies that move otherwise are not in the fluid (the grains may feel it; leave 'solid' "
          "out)");
    if (moved.motion.any() && checkpoints)
      refuse(
          solid_keyword(names),
          "mesh " + std::string(mesh->id) +
              ", which a fix move/mesh turns, and 'checkpoint': at a restart its "
              "facets lie elsewhere than the fluid's grid was cut by",
          "'surface_ang_vel' of the mesh in place of fix move/mesh, which the grains and the fluid feel alike, or no "
          "'checkpoint'");
    turned = turned || moved.motion.any();
    motions.push_back(moved.motion.any() ? moved.motion : surface_motion(*mesh, some).motion);
    all.insert(all.end(), some.begin(), some.end());
  }
  const SurfaceMotion motion = motions.empty() ? SurfaceMotion{} : motions[0];
  for (const SurfaceMotion& other : motions)
    if (other.velocity != motion.velocity || other.turning != motion.turning ||
        (motion.any() && other.origin != motion.origin))
      refuse(solid_keyword(names), "a wall of meshes that move differently",
             "a body each: 'solid NAME mesh FIXID' for every one");
  // One that turns is where it was in its first run.
  const std::size_t triangles = all.size();
  add(*print, all.data(), turned ? 0 : triangles * sizeof(Triangle));
  if (turned) add(*print, &triangles, sizeof triangles);
  if (all.empty())
    refuse(solid_keyword(names), "a mesh without triangles", "a mesh/surface with at least one in the fluid's domain");
  add(*print, &names.sheet, sizeof names.sheet);
  if (motion.any()) add(*print, &motion, sizeof motion);
  return {names.name, std::make_shared<TriangleSet>(without_lids(all, grid)), names.slip, names.sheet, motion};
}

Body region_body(LAMMPS& lammps, const BodyNames& names, const FineGrid& grid, std::uint64_t* print) {
  auto shape = std::make_shared<RegionShape>(region_of(lammps, names), grid);
  check_periodic(names, *shape, grid);
  constexpr int kLooks = 48;  // in each direction
  std::vector<unsigned char> seen;
  for (int k = 0; k < kLooks; ++k)
    for (int j = 0; j < kLooks; ++j)
      for (int i = 0; i < kLooks; ++i) {
        const Int3 at{i, j, k};
        Vec3 x;
        for (int d = 0; d < 3; ++d) x[d] = grid.axis[d].lo() + (at[d] + 0.5) / kLooks * grid.axis[d].length();
        seen.push_back(shape->side(x) == SolidShape::Side::kSolid);
      }
  add(*print, seen.data(), seen.size());
  return {names.name, shape, names.slip};
}

}  // namespace

std::string solid_keyword(const BodyNames& names) {
  return "solid " + names.name;
}

Body ScriptBodies::make(const BodyNames& names, const FineGrid& grid, std::uint64_t* print) const {
  *print = 14695981039346656037u;
  if (names.kind == BodyNames::Kind::kRegion) return region_body(lammps_, names, grid, print);
  const bool kept = script_.checkpoints.by_itself();
  if (names.kind == BodyNames::Kind::kMesh)
    return mesh_body(lammps_, names, {&mesh_of(lammps_, names)}, grid, kept, print);
  FixWallGran& wall = wall_of(lammps_, names);
  if (wall.is_mesh_wall())
    return mesh_body(lammps_, names, {wall.mesh_list(), wall.mesh_list() + wall.n_meshes()}, grid, kept, print);
  const Primitive primitive = primitive_of(wall);
  add(*print, &primitive.axis, sizeof primitive.axis), add(*print, primitive.value.data(), sizeof primitive.value);
  const SurfaceMotion motion = shear_motion(wall, primitive).motion;
  if (motion.any()) add(*print, &motion, sizeof motion);
  return {names.name, primitive_shape(primitive), names.slip, false, motion};
}

Blow ScriptBodies::blow_of(const BodyNames& names) const {
  Blow blow;
  const std::string keyword = solid_keyword(names) + " blow";
  blow.on = true, blow.velocity = names.blow;
  if (!names.blow_region.empty()) {
    Region* const region = &find_region(lammps_, names.blow_region, keyword + " from region");
    blow.where = [region](const Vec3& x) { return region->match(x[0], x[1], x[2]) != 0; };
  }
  if (names.blow_variable.empty()) return blow;
  blow.velocity_now = [this, keyword, variable = names.blow_variable] {
    const double U = names_.equal_style(variable, keyword);
    if (!(U >= 0 && U <= kVelocities.most))
      refuse(
          keyword, "v_" + variable + " = " + text(U),
          "a variable with a finite velocity (m/s) at all times, not below 0 (what leaves needs a side with 'pressure "
          "0'); at most " +
              text(kVelocities.most));
    return U;
  };
  blow.velocity = blow.velocity_now();
  return blow;
}

std::vector<Vec3> ScriptBodies::some_particles() const {
  constexpr long long kSome = 2000;
  const Atom& atom = *lammps_.atom;
  long long all = 0;
  for (int i = 0; i < atom.nlocal; ++i) all += (atom.mask[i] & groupbit_) != 0;
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_LONG_LONG, MPI_SUM, lammps_.world);
  const int step = int(std::max(1LL, all / kSome));
  std::vector<Vec3> own;
  for (int i = 0; i < atom.nlocal; ++i)
    if ((atom.mask[i] & groupbit_) && (!atom.tag || atom.tag[i] % step == 0))
      own.push_back({atom.x[i][0], atom.x[i][1], atom.x[i][2]});
  return gathered(own, lammps_.world);
}

std::vector<Body> ScriptBodies::look(const FineGrid& domain) const {
  std::vector<Body> bodies;
  std::uint64_t print = 0;
  for (const BodyNames& names : script_.bodies) bodies.push_back(make(names, domain, &print));
  return bodies;
}

void ScriptBodies::resolve(FluidSettings& fluid, const FineGrid& grid) {
  fluid.bodies.clear(), fluid.fluid_at.clear();
  const bool again = !prints_.empty();
  for (std::size_t b = 0; b < script_.bodies.size(); ++b) {
    const BodyNames& names = script_.bodies[b];
    std::uint64_t print = 0;
    fluid.bodies.push_back(make(names, grid, &print));
    if (names.blows) fluid.bodies.back().blow = blow_of(names);
    if (again && print != prints_[b])
      refuse(solid_keyword(names), "another shape, place or motion than in the fix's first run",
             "the same: the fluid's grid is cut for good ('unfix' and the fix again take the new one; the fluid then "
             "begins anew)");
    if (!again) prints_.push_back(print);
    for (const Vec3& x : names.fluid_at) {
      for (int d = 0; d < 3; ++d)
        if (!(x[d] >= grid.axis[d].lo() && x[d] <= grid.axis[d].hi()))
          refuse(solid_keyword(names) + " fluid_at", std::string(1, "xyz"[d]) + " = " + text(x[d]),
                 "a point in the fluid's domain, " + text(grid.axis[d].lo()) + " to " + text(grid.axis[d].hi()));
      fluid.fluid_at.push_back(x);
    }
  }
  if (!again && !fluid.bodies.empty()) fluid.particles_at = some_particles();
  for (const BodyNames& names : script_.bodies)
    for (const Vec3& x : names.fluid_at)
      for (const Body& body : fluid.bodies)
        if (body.shape->side(x) == SolidShape::Side::kSolid)
          refuse(solid_keyword(names) + " fluid_at",
                 text(x[0]) + " " + text(x[1]) + " " + text(x[2]) + ", which lies in the solid of " + body.name,
                 "a point in the fluid");
}

void ScriptBodies::find_known(std::vector<WallFacts>& walls, const FluidSettings& fluid, const FineGrid& grid) const {
  if (fluid.bodies.empty()) return;
  const double h = widest_cell(grid);
  const auto at_body = [&](const Vec3& x) {
    Vec3 nearest;
    return std::any_of(fluid.bodies.begin(), fluid.bodies.end(), [&](const Body& body) {
      return body.shape->side(x) == SolidShape::Side::kSolid || body.shape->distance(x, 1.5 * h, nearest) < 1.5 * h;
    });
  };
  for (WallFacts& wall : walls) {
    for (const BodyNames& b : script_.bodies)
      wall.solid = wall.solid || (b.kind == BodyNames::Kind::kMesh && b.id == wall.id) ||
                   (b.kind == BodyNames::Kind::kWall && b.id == wall.wall);
    if (wall.solid) continue;
    bool covered = true;
    if (wall.kind == WallFacts::Kind::kMesh) {
      auto* mesh = dynamic_cast<FixMeshSurface*>(find_fix(lammps_, wall.id));
      if (!mesh) continue;
      for (const Triangle& t : mesh_triangles(*mesh, lammps_.world)) {
        Vec3 x;
        for (int d = 0; d < 3; ++d) x[d] = (t[0][d] + t[1][d] + t[2][d]) / 3;
        covered = covered && at_body(x);
      }
    } else {
      const Domain& box = *lammps_.domain;
      constexpr int kPoints = 24;  // across the box, or around a cylinder
      const int e = wall.axis == 0 ? 1 : 0, f = wall.axis == 2 ? 1 : 2;
      for (int i = 0; i < kPoints; ++i)
        for (int j = 0; j < kPoints; ++j) {
          const double a = (i + 0.5) / kPoints, b = (j + 0.5) / kPoints;
          Vec3 x;
          if (wall.kind == WallFacts::Kind::kPlane) {
            x[wall.axis] = wall.position;
            x[e] = box.boxlo[e] + a * box.prd[e], x[f] = box.boxlo[f] + b * box.prd[f];
          } else {
            x[wall.axis] = box.boxlo[wall.axis] + a * box.prd[wall.axis];
            x[e] = wall.bounds[2 * e] + wall.radius * (1 + std::cos(2 * kPi * b));
            x[f] = wall.bounds[2 * f] + wall.radius * (1 + std::sin(2 * kPi * b));
          }
          bool inside = true;
          for (int d = 0; d < 3; ++d) inside = inside && x[d] >= box.boxlo[d] && x[d] <= box.boxhi[d];
          covered = covered && (!inside || at_body(x));
        }
    }
    wall.solid = covered;
  }
}

std::vector<double> ScriptBodies::drawn_areas(const FluidSettings& fluid, const FineGrid& grid) const {
  std::vector<double> areas(script_.bodies.size(), 0.0);
  double h = 1e300;
  for (const Axis& a : grid.axis)
    for (int i = 0; i < a.n(); ++i) h = std::min(h, a.width(i));
  for (std::size_t b = 0; b < areas.size(); ++b) {
    const BodyNames& names = script_.bodies[b];
    if (!names.blows || names.kind != BodyNames::Kind::kMesh) continue;
    for (const Triangle& t : mesh_triangles(mesh_of(lammps_, names), lammps_.world)) {
      Vec3 u, v;
      double longest = 0, square = 0;
      for (int d = 0; d < 3; ++d) u[d] = t[1][d] - t[0][d], v[d] = t[2][d] - t[0][d];
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        square += std::pow(u[e] * v[f] - u[f] * v[e], 2);
        longest = std::max({longest, std::abs(u[d]), std::abs(v[d])});
      }
      // By the centres of parts below half a cell.
      const int n = int(std::clamp(std::ceil(2 * longest / h), 1.0, 200.0));
      int inside = 0;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const bool turned = i + j >= n;
          const double p = (turned ? n - i - 1.0 / 3 : i + 1.0 / 3) / n,
                       q = (turned ? n - j - 1.0 / 3 : j + 1.0 / 3) / n;
          Vec3 x;
          bool in = true;
          for (int d = 0; d < 3; ++d) {
            x[d] = t[0][d] + p * u[d] + q * v[d];
            in = in && x[d] >= grid.axis[d].lo() && x[d] <= grid.axis[d].hi();
          }
          inside += in && (!fluid.bodies[b].blow.where || fluid.bodies[b].blow.where(x));
        }
      areas[b] += 0.5 * std::sqrt(square) * inside / (double(n) * n);
    }
  }
  return areas;
}

std::vector<std::string> ScriptBodies::doubts() {
  std::vector<std::string> found;
  const Modify& modify = *lammps_.modify;
  const auto is_wall = [&](const std::string& mesh) {
    for (int f = 0; f < modify.nfix; ++f)
      if (auto* wall = dynamic_cast<FixWallGran*>(modify.fix[f]))
        if (wall->is_mesh_wall())
          for (int m = 0; m < wall->n_meshes(); ++m)
            if (mesh == wall->mesh_list()[m]->id) return true;
    return false;
  };
  for (const BodyNames& names : script_.bodies) {
    if (names.kind == BodyNames::Kind::kMesh && !is_wall(names.id))
      found.push_back(
          "the mesh of 'solid " + names.name +
          "' is no wall for the particles, which pass through it: add 'fix ID all wall/gran ... mesh n_meshes "
          "1 meshes " +
          names.id + "'");
    std::string what, why;
    if (names.kind != BodyNames::Kind::kRegion) {
      FixWallGran* const wall = names.kind == BodyNames::Kind::kWall ? &wall_of(lammps_, names) : nullptr;
      if (wall && !wall->is_mesh_wall()) {
        what = "wall " + names.id, why = shear_motion(*wall, primitive_of(*wall)).why;
      } else {
        const std::vector<FixMeshSurface*> meshes =
            wall ? std::vector<FixMeshSurface*>(wall->mesh_list(), wall->mesh_list() + wall->n_meshes())
                 : std::vector<FixMeshSurface*>{&mesh_of(lammps_, names)};
        for (FixMeshSurface* mesh : meshes)
          if (const std::string its = surface_motion(*mesh, mesh_triangles(*mesh, lammps_.world)).why; !its.empty())
            what = "the surface of mesh " + std::string(mesh->id), why = its;
      }
    }
    if (!why.empty() && !names.slip)
      found.push_back(what + " moves " + why + ". The particles feel that; to the fluid the wall is at rest");
  }
  return found;
}

}  // namespace twogrid
