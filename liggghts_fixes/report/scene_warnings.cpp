#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"
#include "coupling/forces/drag.h"
#include "liggghts_fixes/report/bed_end.h"
#include "liggghts_fixes/report/coupling_watch.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/script/boundary_words.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

constexpr double kPatchError = 0.02;  // of a patch's area, above which it is told

/// a < b, and by more than rounding: what a script gives as exactly the limit is no case for a warning.
bool below(double a, double b) {
  return a < b * (1 - 1e-9);
}

/// Of a wall inside the fluid's domain that the fluid doesn't know; else empty.
std::string blown_through(const WallFacts& wall, const Settings& s, double h) {
  const auto& dom = s.domain;
  const double slack = 0.01 * h;
  if (wall.solid) return "";
  const bool mesh = wall.kind == WallFacts::Kind::kMesh;
  const std::string line = "'fix_modify " + s.id + " solid " + wall.id + (mesh ? " mesh " : " wall ") + wall.id + "'";
  if (wall.kind == WallFacts::Kind::kPlane) {
    const int i = wall.axis;
    const double lo = dom[2 * i], hi = dom[2 * i + 1];
    if (wall.position <= lo + slack || wall.position >= hi - slack) return "";
    const bool high = wall.position > 0.5 * (lo + hi);
    return "the wall of fix " + wall.id + " at " + "xyz"[i] + " = " + text(wall.position) +
           " stands inside the fluid's domain, and the fluid blows through it: let the domain " +
           (high ? "end" : "begin") + " there (domain ... " + kSideNames[2 * i + high] + " " + text(wall.position) +
           " ...), or say " + line;
  }
  double farthest = 0;  // corner of the domain from a cylinder's axis
  for (int i = 0; i < 3; ++i) {
    if (wall.bounds[2 * i] >= dom[2 * i + 1] - slack || wall.bounds[2 * i + 1] <= dom[2 * i] + slack) return "";
    if (i == wall.axis) continue;
    const double centre = 0.5 * (wall.bounds[2 * i] + wall.bounds[2 * i + 1]);
    const double away = std::max(std::abs(dom[2 * i] - centre), std::abs(dom[2 * i + 1] - centre));
    farthest += away * away;
  }
  if (wall.kind == WallFacts::Kind::kCylinder && farthest <= wall.radius * wall.radius) return "";
  return "the wall of fix " + wall.wall + (mesh ? " (mesh " + wall.id + ")" : " (cylinder)") +
         " stands inside the fluid's domain, and the fluid blows through it: say " + line +
         " before the first run, and it is solid for the fluid as well";
}

/// What to do about it.
std::string shorter_end(const Settings& s, const SettledBed& bed, double d) {
  const bool trilinear = s.deposit == Deposit::kTrilinear;
  if (bed.height / bed.cells <= 2 * d * (1 + 1e-9))  // cells are as small as they may be
    return trilinear ? "; 'method sharp' lacks less" : "";
  return std::string("; ") +
         (s.ratio[bed.along] > 1 ? "lower ratio along gravity" : "take more fine cells along gravity, by 'fine'") +
         (trilinear ? ", or 'method sharp'" : "");
}

/// Particle cells that don't hold the largest particles, those to come included; else empty.
std::string small_cells(const Settings& s, const SceneNumbers& n, const SceneFacts& facts) {
  const double d = std::max(facts.d_max, facts.d_most);
  const bool rough = s.deposit == Deposit::kCentroid || s.deposit == Deposit::kTrilinear;
  if (!(d > 0) || !below(n.h_coarse, rough ? 2 * d : d) || s.deposit == Deposit::kCube) return "";
  std::string t = "the smallest particle cell is " + brief(n.h_coarse / d) + " particle diameters, below " +
                  (rough ? "2, so that the void fraction is rough: "
                         : "1: a particle fills it, and what is beyond the eps bound goes to cells beside: ");
  if (facts.chosen_for > 0 && below(facts.chosen_for, d))
    return t + "the cells were chosen (auto) for particles up to " + brief(facts.chosen_for) +
           " m and are kept, and now there are some of " + brief(d) +
           " m, or a template of them: let all fixes particletemplate/sphere and insert/... stand before the first run "
           "with the fluid, or give numbers for 'fine' and 'ratio'";
  if (rough) return t + "raise ratio, or 'deposit exact'";
  return t + (s.one_grid ? "take larger cells by 'fine', or a two-grid method" : "raise ratio");
}

}  // namespace

std::vector<std::string> scene_warnings(const Settings& s, const FineGrid& grid, const SceneFacts& facts,
                                        const SceneNumbers& n, bool every_auto) {
  std::vector<std::string> w;
  const double d = facts.d_max;
  const DragLaw* const law = find_drag_law(s.drag);
  if (facts.sizes_differ() && law && !law->for_mixtures)
    w.push_back("diameters from " + brief(facts.d_min) + " to " + brief(facts.d_max) + " m, and the drag law " +
                s.drag +
                " knows one size: it takes each particle for one among its like; for mixtures there is 'drag " +
                mixture_law_names() + "'");
  const SettledBed bed = settled_bed(s, grid, facts);
  if (const double missing = short_at_end(bed, s.deposit); missing > kMostMissing && !facts.end_told)
    w.push_back("a bed of " + brief(bed.height) + " m holds few particle cells: where it ends, drag falls short by " +
                percent_short(missing) + " of its pressure drop" + shorter_end(s, bed, d));
  if (const std::string sentence = small_cells(s, n, facts); !sentence.empty()) w.push_back(sentence);
  for (int i = 0; i < 3; ++i)
    if (d > 0 && s.fine[i] == 1 && below(grid.axis[i].length(), 2 * d) && s.deposit == Deposit::kCentroid)
      w.push_back(std::string("the domain is ") + brief(grid.axis[i].length() / d) + " particle diameters deep in " +
                  "xyz"[i] + ": a void fraction over so thin a cell is an assumption");
  if (facts.contact_time > 0 && below(facts.contact_time, 10 * facts.dem_dt))
    w.push_back("a contact lasts " + brief(facts.contact_time / facts.dem_dt) +
                " DEM steps, fewer than 10: lower timestep below " + brief(facts.contact_time / 20) +
                " s, or soften the contact");
  const double interval = s.every * facts.dem_dt;
  if (n.tau > 0 && below(CouplingWatch::kUnheld * n.tau, interval) && s.hold_flux == Choice::kOff)
    w.push_back("the coupling interval is " + brief(interval / n.tau) +
                " response times of the bed with 'hold off': lower every below " +
                std::to_string(std::max(1, int(CouplingWatch::kUnheld * n.tau / facts.dem_dt))) + ", or 'hold auto'");
  if (below(5, n.cfl))
    w.push_back("the fluid crosses " + brief(n.cfl) + " fine cells in one coupling interval: lower every towards " +
                std::to_string(std::max(1, int(s.every / n.cfl))) +
                (s.every / n.cfl < 1 ? ", and timestep to " + brief(facts.dem_dt * s.every / n.cfl) + " s" : ""));
  if (n.U_varies && s.every > 0)
    w.push_back(
        "an inlet, or a surface that blows, follows a variable: velocity U and all that follows from it (Re, St, CFL" +
        std::string(every_auto ? ", every auto" : "") +
        ") hold for its value now; look at f_ID[3] for the run's Courant number");
  if (s.deposit == Deposit::kCentroid && !s.one_way && !facts.still && n.U > 0 && below(n.U, n.noise))
    w.push_back(
        "with 'deposit centroid' a particle that changes its particle cell replaces fluid within one coupling "
        "interval, at " +
        brief(n.noise) + " m/s over the cell's side (V_p/(interval area)) where the flow has " + brief(n.U) +
        " m/s, and the pressure is noisy, in a liquid more than useful: choose 'deposit trilinear' or 'exact', "
        "or raise every or ratio");
  for (int side = 0; side < 6; ++side) {
    const std::vector<PatchSize> sizes = patch_sizes(s.fluid, side, grid);
    for (std::size_t c = 1; c < sizes.size(); ++c) {
      const double more = sizes[c].drawn > 0 ? sizes[c].faces / sizes[c].drawn - 1 : 0.0;
      if (std::abs(more) > kPatchError)
        w.push_back(
            "patch " + s.fluid.side[side][c].name + " of " + kSideNames[side] + " takes whole fine faces, " +
            brief(sizes[c].faces) + " m2 where " + brief(sizes[c].drawn) + " m2 are drawn (" + (more > 0 ? "+" : "") +
            brief(100 * more) +
            " %), and an inlet's flow is as wrong: move its edges onto sides of fine cells, choose 'fine' so that "
            "they lie there, or take more cells across it");
    }
  }
  for (const WallFacts& wall : facts.walls)
    if (const std::string sentence = blown_through(wall, s, n.h_min); !sentence.empty()) w.push_back(sentence);
  if (facts.cut && facts.cut->narrowest > 0 && below(facts.cut->narrowest, 4))
    w.push_back("the narrowest opening between walls is " + brief(facts.cut->narrowest) +
                " cells wide, below 4: its flow is wrong by some per cent to tens of them; take finer cells by 'fine'");
  for (std::size_t b = 0; facts.cut && b < facts.cut->bodies.size(); ++b)
    if (const CutReport::OfBody& body = facts.cut->bodies[b]; body.cells == 0 && body.area == 0 && body.volume == 0)
      w.push_back("body 'solid " + body.name + "' meets no cell of the fluid's domain: see its place and its size");
  if (facts.nodes && facts.nodes->split > 0)
    w.push_back(
        "a wall parts " + std::to_string(facts.nodes->split) +
        " particle cells in two, and the void fraction smears across it: lower ratio, or move the wall onto sides "
        "of particle cells");
  if (facts.equal_kn > 0)
    w.push_back("model hooke raises a number to a power at every contact: hooke/stiffness with kn " +
                brief(facts.equal_kn) +
                " N/m has the same contact time between these particles, and runs some three times as fast");
  if (s.one_way) w.push_back("one-way: the particles feel the fluid, the fluid does not feel them");
  return w;
}

}  // namespace twogrid
