#include "liggghts_fixes/report/coupling_watch.h"

#include <algorithm>
#include <stdexcept>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

std::string percent(double share) {
  return brief(100 * share) + " %";
}

/// The step that keeps a particle from crossing more than kTravel particle cells: first by every, then by timestep.
std::string shorter_interval(double travel, int steps, double dem_dt) {
  const double allowed = steps * CouplingWatch::kTravel / travel;  // DEM steps of today's length
  if (allowed >= 1 && steps > 1) return "lower every to " + std::to_string(std::min(int(allowed), steps - 1));
  const std::string shorter = "timestep to " + brief(std::min(allowed, 1.0) * dem_dt) +
                              " s, or raise ratio: larger particle cells are crossed more slowly";
  return steps > 1 ? "lower every to 1 and " + shorter : "lower " + shorter;
}

}  // namespace

bool CouplingWatch::Told::due(double value, double limit) {
  if (!(value > limit) || !(value > 2 * at)) return false;
  at = value;
  return true;
}

std::vector<std::string> CouplingWatch::look(const Report& r, int steps, double dem_dt) {
  std::vector<std::string> said;
  if (dt_ > 0 && courant_.due(r.cfl, kCourant)) {
    const std::string found = "the Courant number is " + brief(r.cfl) + " with fluid steps of 'dt' " + text(dt_) + " s";
    if (r.cfl > kMostCourant)
      throw std::runtime_error(found + ", wanted: at most " + text(kMostCourant) +
                               "; lower 'dt', or leave it out: 'cfl' then chooses the step");
    said.push_back(found + ", wanted: at most " + text(kCourant) +
                   ", above which convection is stable only where drag damps it; lower 'dt' to " +
                   brief(0.4 * kCourant * dt_ / r.cfl) + " s, or leave it out: 'cfl' then chooses the step");
  }
  if (steps > 0 && travel_.due(r.travel, kTravel))
    said.push_back("a particle crosses " + text(r.travel) + " particle cells in a coupling interval of " +
                   std::to_string(steps) + " steps, wanted: at most " + text(kTravel) + "; " +
                   shorter_interval(r.travel, steps, dem_dt));
  if (unheld_ && steps > 0 && drag_.due(r.max_drag_number, kUnheld))
    said.push_back("a coupling interval of " + std::to_string(steps) + " steps lasts " + brief(r.max_drag_number) +
                   " response times of a particle, wanted with 'hold off': at most " + brief(kUnheld) +
                   ", above which fluid and particles swing each other up; leave 'hold' out (auto), or lower every" +
                   (steps * kUnheld >= r.max_drag_number
                        ? " to " + std::to_string(int(steps * kUnheld / r.max_drag_number))
                        : " to 1 and timestep to " + brief(dem_dt * steps * kUnheld / r.max_drag_number) + " s"));
  const double solids = r.solid_volume > 0 ? 1 / r.solid_volume : 0.0;
  const bool clip = bound_ == EpsBound::kClip;
  const std::string bound = std::string("'eps bound ") + (clip ? "clip " : "move ") + text(eps_min_) + "'";
  if (moved_.due(r.volume_moved * solids, kMoved))
    said.push_back(bound + (clip ? " throws away " : " moves ") + percent(r.volume_moved * solids) +
                   " of the solids' volume, wanted: at most " + percent(kMoved) +
                   "; particles lie closer, or overlap more, than the bound allows, and the fluid sees " +
                   (clip ? "fewer of them" : "them elsewhere") +
                   ": raise ratio (particle cells of 3 diameters), take the overlap out (stiffer contacts, a lower "
                   "timestep, obstacles of spheres that touch), or lower the bound");
  if (unplaced_.due(r.volume_unplaced * solids, kError))
    said.push_back(bound + " cannot be kept: " + percent(r.volume_unplaced * solids) + " of the solids' volume (" +
                   brief(r.volume_unplaced) +
                   " m3) lies above it and finds no room anywhere, and the void fraction goes "
                   "down to " +
                   brief(r.eps_min) + "; lower the bound, or let the domain be larger");
  if (behind_.due(double(r.behind_walls), 0))
    said.push_back(
        std::to_string(r.behind_walls) + " particle(s), one of them of ID " + std::to_string(r.tag_behind) +
        ", lie in a body, more than a particle cell behind the fluid's wall, and feel no fluid, wanted: none; "
        "where they have gone through it, give the particles a wall there (fix wall/gran) or lower timestep; "
        "where that is their place, the body is another one than they feel (fix_modify solid)");
  // What clip throws away is this error, and is told above.
  if (!clip && volume_.due(r.solid_volume_error, kError))
    said.push_back("the grid holds another volume of solids than the particles have, by " +
                   brief(r.solid_volume_error) + " of it (f_ID[6]), wanted: at most " + brief(kError) +
                   "; say 'neigh_modify delay 0 every 1 check yes' and lower timestep, so that no particle leaves its "
                   "rank unseen");
  if (momentum_.due(r.momentum_error, kError))
    said.push_back("what the fluid gives the particles and what it gets back differ by " + brief(r.momentum_error) +
                   " (f_ID[7]), wanted: at most " + brief(kError) +
                   "; lower every or timestep: an exchange so strong is lost in the rounding of numbers");
  return said;
}

std::string losses(Schedule& schedule, long long now, long long most, long long step) {
  const long long told = schedule.count_particles(now), lost = schedule.state().lost;
  if (most >= 0 && lost > most)
    throw std::runtime_error("most_lost: found " + std::to_string(lost) +
                             " particle(s) that have vanished, wanted at most " + std::to_string(most) +
                             ": look where they leave (a side without a wall that is not periodic, or a wall they "
                             "break through: lower timestep), or raise 'most_lost' where the script deletes them");
  if (told == 0) return "";
  return std::to_string(told) + " particle(s) have vanished up to step " + std::to_string(step) +
         ": unless the script deletes them, they left the box by a side that is not periodic; put a wall there, or "
         "lower timestep if they broke through one; 'most_lost N' ends a run that loses more than N";
}

}  // namespace twogrid
