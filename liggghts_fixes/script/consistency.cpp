#include "liggghts_fixes/script/consistency.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

const char* const kAxis = "xyz";

/// The edge of a cube or the width of a kernel, that stands on cells of `block` fine ones.
void check_length(const std::string& keyword, const std::string& what, double length, const Settings& s,
                  const FineGrid& grid, const Int3& block) {
  constexpr double kLeast = 1e-3;  // of a cell: below, the whole of it lies in one cell, and 1/length overflows at last
  double narrowest = std::numeric_limits<double>::max(), longest = 0;
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid.axis[d];
    longest = std::max(longest, a.length());
    for (int i = 0; i + block[d] <= a.n(); i += block[d])
      narrowest = std::min(narrowest, a.node(i + block[d]) - a.node(i));
    if (length > a.length() && s.fine[d] > 1)
      refuse(keyword, text(length),
             "a" + std::string(what == "edge" ? "n " : " ") + what + " that fits into the domain, " + text(a.length()) +
                 " in " + kAxis[d]);
  }
  if (!(length >= kLeast * narrowest && length <= longest))
    refuse(keyword, text(length),
           "a" + std::string(what == "edge" ? "n " : " ") + what + " of some particle diameters (m), at least " +
               text(kLeast) + " of the smallest cell, " + text(narrowest) + " m");
}

/// Cells of such different widths are a slip, and widths overflow at last.
void check_stretch(const Settings& s, int d) {
  const double steps = s.stretch_symmetric[d] ? (s.fine[d] - 1) / 2 : s.fine[d] - 1;
  if (steps * std::abs(std::log(s.stretch[d])) <= std::log(kMostStretch)) return;
  refuse("stretch",
         text(s.stretch[d]) + " over " + std::to_string(s.fine[d]) + " cells in " + kAxis[d] + ", the widest of them " +
             brief(std::pow(10, steps * std::abs(std::log10(s.stretch[d])))) + " times as wide as the narrowest",
         "a growth nearer to 1, that makes it at most " + brief(kMostStretch) + " times");
}

}  // namespace

std::array<bool, 3> periodic_directions(const FluidSettings& fluid) {
  std::array<bool, 3> p{};
  for (int d = 0; d < 3; ++d) p[d] = !fluid.side[2 * d].empty() && fluid.side[2 * d][0].kind == BoundaryKind::kPeriodic;
  return p;
}

FineGrid fine_grid(const Settings& s, const std::array<bool, 3>& periodic) {
  FineGrid grid;
  for (int d = 0; d < 3; ++d)
    grid.axis[d] =
        Axis(graded_nodes(s.domain[2 * d], s.domain[2 * d + 1], s.fine[d], s.stretch[d], s.stretch_symmetric[d]),
             periodic[d]);
  return grid;
}

void check_box_boundary(const int boundary[3][2]) {
  static const char kCode[] = "pfsm";
  bool bad = false;
  std::string found, wanted;
  for (int d = 0; d < 3; ++d) {
    std::string lo(1, kCode[boundary[d][0]]), hi(1, kCode[boundary[d][1]]);
    bad |= boundary[d][0] > 1 || boundary[d][1] > 1;
    found += " " + (lo == hi ? lo : lo + hi);
    wanted += boundary[d][0] == 0 ? " p" : " f";
  }
  if (bad)
    refuse("boundary", "'boundary" + found + "', whose s or m sides move the box",
           "a box that stays, 'boundary" + wanted + "', before the box is created");
}

void complete(Script& script, const BoxFacts& box) {
  Settings& s = script.settings;
  const OutputSettings& out = s.output;
  s.fluid.wall_stress = out.writes() && std::find(out.fields.begin(), out.fields.end(), "walls") != out.fields.end();
  if (!script.domain_given) s.domain = box.bounds;
  for (int d = 0; d < 3; ++d) {
    const double lo = s.domain[2 * d], hi = s.domain[2 * d + 1];
    const double box_lo = box.bounds[2 * d], box_hi = box.bounds[2 * d + 1], slack = 1e-9 * (box_hi - box_lo);
    const std::string found = text(lo) + " to " + text(hi) + " in " + kAxis[d];
    for (double x : {box_lo, box_hi, lo, hi})
      if (!(x >= kCoordinates.least && x <= kCoordinates.most))
        refuse("domain", found + ", box " + text(box_lo) + " to " + text(box_hi),
               "coordinates in m, " + text(kCoordinates.least) + " to " + text(kCoordinates.most));
    if (!(lo < hi)) refuse("domain", found, "a lower bound below the upper one");
    // of its cells, volumes and squares are formed
    if (!((hi - lo) / s.fine[d] > 1e-50 && hi - lo < 1e50 && hi - lo > 1e-9 * std::max(std::abs(lo), std::abs(hi))))
      refuse("domain", found, "lengths in m that can be divided into cells");
    if (lo < box_lo - slack || hi > box_hi + slack)
      refuse("domain", found, "bounds inside the simulation box, " + text(box_lo) + " to " + text(box_hi));
    // bounds that mean the box's are the box's, to the bit
    if (std::abs(lo - box_lo) <= slack) s.domain[2 * d] = box_lo;
    if (std::abs(hi - box_hi) <= slack) s.domain[2 * d + 1] = box_hi;
  }

  FluidSettings& f = s.fluid;
  for (int d = 0; d < 3; ++d) {
    const bool spans = s.domain[2 * d] == box.bounds[2 * d] && s.domain[2 * d + 1] == box.bounds[2 * d + 1];
    const bool periodic = box.periodic[d] && spans;
    for (int side : {2 * d, 2 * d + 1}) {
      if (f.side[side].empty()) {
        f.side[side].emplace_back();
        script.names[side].emplace_back();
      }
      BoundaryCondition& whole = f.side[side][0];
      const std::string keyword = "boundary " + std::string(kSideNames[side]);
      if (periodic) {
        if (f.side[side].size() > 1 || (script.side_given[side] && whole.kind != BoundaryKind::kPeriodic))
          refuse(
              keyword, "a condition on a side that is periodic for the particles",
              std::string("no condition there, or f instead of p in ") + kAxis[d] + " in LIGGGHTS' boundary command");
        whole.kind = BoundaryKind::kPeriodic;
      } else if (whole.kind == BoundaryKind::kPeriodic) {
        refuse(keyword, "periodic",
               spans ? std::string("p instead of f in ") + kAxis[d] +
                           " in LIGGGHTS' boundary command, or another condition"
                     : std::string("a domain that spans the whole periodic box in ") + kAxis[d]);
      }
      for (const BoundaryCondition& c : f.side[side])
        if (s.fine[d] == 1 && (c.kind == BoundaryKind::kInlet || c.kind == BoundaryKind::kPressure))
          refuse(keyword + (c.name.empty() ? "" : " patch " + c.name),
                 std::string("flow through a side of a direction with fine 1, ") + kAxis[d],
                 "slip or periodic there, or at least 2 fine cells");
    }
    if (f.flow_rate_set[d] && f.pressure_gradient[d] != 0)
      refuse("flow_rate", std::string("it in ") + kAxis[d] + " together with pressure_gradient", "one of the two");
    if (s.stretch[d] != 1 && periodic)
      refuse("stretch", std::string("it in ") + kAxis[d] + ", which is periodic", "equal cells there");
  }
  for (int d = 0; d < 3; ++d) check_stretch(s, d);
  const FineGrid grid = fine_grid(s, periodic_directions(f));
  f.check(grid);
  if (f.gap_friction && std::none_of(s.fine.begin(), s.fine.end(), [](int n) { return n == 1; }))
    refuse("gap friction", "on with fine " + text(s.fine[0]) + " " + text(s.fine[1]) + " " + text(s.fine[2]),
           "a direction with one fine cell, or off");
  const bool cube = s.deposit == Deposit::kCube || s.read == Read::kCube;
  if (cube)
    check_length(s.deposit == Deposit::kCube ? "deposit cube" : "read cube", "edge", s.cube_edge, s, grid, s.ratio);
  if (s.read == Read::kKernel) check_length("read kernel", "width", s.kernel_width, s, grid, {1, 1, 1});
  if (s.one_grid && s.ratio != Int3{1, 1, 1})
    refuse("method " + s.method,
           "ratio " + text(s.ratio[0]) + " " + text(s.ratio[1]) + " " + text(s.ratio[2]) + " in the fix command",
           "ratio 1 1 1, for this method sees the particles on the fine cells; or one of the two-grid methods");
  if (s.output.every > 0 && s.output.file.empty()) refuse("output", "no file", "file and a name");
  if (s.output.every == 0 && !s.output.file.empty() && !s.output.off)
    refuse("output", "no every", "every and a number of DEM steps");
  if (s.output.every > 0 && !script.every_auto && s.output.every % s.every != 0)
    refuse("output every", std::to_string(s.output.every), "a multiple of the fix's every, " + std::to_string(s.every));
}

}  // namespace twogrid
