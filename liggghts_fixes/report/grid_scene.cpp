#include "liggghts_fixes/report/grid_scene.h"

#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"
#include "cfd/boundary/region_outline.h"
#include "liggghts_fixes/report/bed_end.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

constexpr int kSomeCells = 64;

constexpr double kAlike = 1e-3;

/// A region: what has been found of it; as a rectangle where it is one.
void outline_of_region(const BoundaryCondition& c, int side, const std::array<double, 6>& domain, Opening& o) {
  const RegionOutline outline = c.shape.outline ? *c.shape.outline : measure_region(c.shape, side, domain);
  const int n = direction(side), e = n == 0 ? 1 : 0, f = n == 2 ? 1 : 2;
  if (!outline.found)
    refuse("boundary " + std::string(kSideNames[side]) + " patch " + c.name + " region",
           "with fine or ratio auto, a region of which no point was found on that side, at " +
               std::string(1, "xyz"[n]) + " = " + text(domain[side]),
           "a region that reaches through the side there, or 'rect' or 'circle', or numbers for fine and ratio");
  o.extent = outline.extent, o.area = outline.area;
  const double framed = (o.extent[1] - o.extent[0]) * (o.extent[3] - o.extent[2]);
  if (std::abs(outline.area - framed) < kAlike * framed) o.kind = PatchShape::Kind::kRectangle;
  Vec3 x;
  x[n] = domain[side];
  o.inside = [inside = c.shape.inside, x, e, f](double a, double b) mutable {
    x[e] = a, x[f] = b;
    return inside(x);
  };
}

/// Sums over particles differ in their last digits from one number of ranks to another; grids must not.
double seven_digits(double value) {
  if (!(value > 0)) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 6);
  return std::round(value / unit) * unit;
}

std::string sizes_text(const SceneFacts& f) {
  std::string t = f.sizes_of_templates ? ", of the templates of particles to come" : ", of the particles";
  if (f.d_most > f.d_rough * (1 + 1e-6))
    t += " (equal spheres that scatter as much; the largest have " + brief(f.d_most) + " m)";
  return t;
}

}  // namespace

Script with_some_cells(const Script& script) {
  Script some = script;
  for (int d = 0; d < 3; ++d) {
    if (script.fine_auto[d] || script.ratio_auto[d]) some.settings.ratio[d] = 1;
    if (script.fine_auto[d]) some.settings.fine[d] = kSomeCells;
  }
  if (script.grids_auto()) some.settings.fluid.gap_friction = false;  // hangs on them
  return some;
}

GivenGrids given_grids(const Script& script) {
  const Settings& s = script.settings;
  GivenGrids given;
  given.stretch = s.stretch, given.symmetric = s.stretch_symmetric;
  for (int d = 0; d < 3; ++d) {
    given.fine[d] = script.fine_auto[d] ? 0 : s.fine[d];
    given.ratio[d] = script.ratio_auto[d] ? 0 : s.ratio[d];
  }
  return given;
}

GridScene grid_scene(const Settings& s, const SceneFacts& facts, const std::vector<WidthAcross>& widths) {
  GridScene g;
  g.domain = s.domain;
  g.d = seven_digits(facts.d_rough), g.d_max = facts.d_most, g.d_text = sizes_text(facts);
  const bool rough = s.deposit == Deposit::kCentroid || s.deposit == Deposit::kTrilinear;
  g.one_grid = s.one_grid, g.method = s.method;
  g.least = rough ? 2 : s.one_grid ? 0 : 1;
  g.least_common = s.deposit == Deposit::kCentroid ? 3 : 2.5;
  if (s.read == Read::kKernel) g.kernel = s.kernel_width;
  if (const SettledBed bed = settled_bed(s, fine_grid(s, periodic_directions(s.fluid)), facts);
      bed.along >= 0 && s.deposit != Deposit::kCube) {  // a cube's volume doesn't hang on the cells
    SettledBed of_one = bed;
    of_one.cells = 1;
    if (const double missing = short_at_end(of_one, s.deposit); missing > 0)
      g.bed = seven_digits(bed.height), g.bed_cells = missing / kMostMissing, g.bed_missing = kMostMissing;
  }
  for (int d = 0; d < 3; ++d)
    if (facts.gravity[d] != 0 && (g.along < 0 || std::abs(facts.gravity[d]) > std::abs(facts.gravity[g.along])))
      g.along = d;
  for (int d = 0; d < 3; ++d)
    g.flows[d] = d == g.along || s.fluid.flow_rate_set[d] || s.fluid.pressure_gradient[d] != 0 ||
                 s.fluid.initial_velocity[d] != 0 || (d < 2 && s.fluid.initial_vortex != 0);
  for (int side = 0; side < 6; ++side) {
    const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
    const auto& all = s.fluid.side[side];
    for (const BoundaryCondition& c : all) {
      const bool passes = c.kind == BoundaryKind::kInlet || c.kind == BoundaryKind::kPressure;
      g.flows[d] = g.flows[d] || passes;
      g.rubs[d] = g.rubs[d] || c.kind == BoundaryKind::kNoSlip;
      if (c.name.empty()) continue;
      Opening o;
      o.name = "patch " + c.name + " of " + kSideNames[side];
      o.side = side, o.kind = c.shape.kind, o.asks = passes;
      const auto& v = c.shape.value;
      const std::array<double, 4> whole{s.domain[2 * e], s.domain[2 * e + 1], s.domain[2 * f], s.domain[2 * f + 1]};
      if (o.kind == PatchShape::Kind::kRectangle)
        for (int q = 0; q < 4; ++q) o.extent[q] = q % 2 ? std::min(v[q], whole[q]) : std::max(v[q], whole[q]);
      if (o.kind == PatchShape::Kind::kCircle) o.extent = {v[0] - v[2], v[0] + v[2], v[1] - v[2], v[1] + v[2]};
      if (o.kind == PatchShape::Kind::kRegion) outline_of_region(c, side, s.domain, o);
      if (o.extent[0] < o.extent[1] && o.extent[2] < o.extent[3]) g.openings.push_back(o);
    }
  }
  g.widths = widths;
  return g;
}

}  // namespace twogrid
