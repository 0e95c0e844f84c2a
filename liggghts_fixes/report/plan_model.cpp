#include "liggghts_fixes/report/plan_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace twogrid {

namespace {

/// A direction's cuts that other ranks lie behind: none, one, or two for the most of them.
double faces(int bricks) {
  return bricks == 1 ? 0.0 : 2.0 * (bricks - 1) / bricks;
}

double all_faces(const Int3& b) {
  return faces(b[0]) + faces(b[1]) + faces(b[2]);
}

/// Ghosts over own particles, for particles `spacing` apart in the part of the box where they lie.
double ghosts(const PlannedRun& run, const Int3& bricks) {
  if (!(run.reach > 0)) return 0;
  double grown = 1;
  for (int d = 0; d < 3; ++d) {
    const double wide = run.parts.length[d] * (run.parts.hi[d] - run.parts.lo[d]) / bricks[d];
    if (wide > 0) grown *= 1 + faces(bricks[d]) * run.reach / wide;
  }
  return grown - 1;
}

/// Seconds that a rank sends and waits for others in a run.
double messages(const PlannedRun& run, const Int3& bricks, int ranks) {
  if (ranks == 1) return 0;
  const double f = all_faces(bricks), log = std::log2(double(ranks));
  return kPlannedMessage * (double(run.steps) * (1.7 * f + 5 * log) + run.fluid_steps * (12 * f + 10 * log));
}

/// Of particles' work a ghost costs so much of a particle: it is sent, binned, and its contacts are evaluated twice.
constexpr double kGhost = 0.4;

double particle_share(const PlannedRun& run, int ranks) {
  return fullest_share(run.parts, ranks) * (1 + kGhost * ghosts(run, planned_bricks(run.parts, ranks)));
}

/// A brick's halo of one cell costs half a cell each.
double cell_share(const PlannedRun& run, int ranks) {
  const double own = std::max(1.0, run.cells / ranks);
  const double halo = ranks == 1 ? 0.0 : 2 * all_faces(planned_bricks(run.parts, ranks)) * std::pow(own, 2.0 / 3);
  return (own + 0.5 * halo) / std::max(1.0, run.cells);
}

/// Of all particles, in the fullest of these bricks.
double share_of(const PlannedParts& parts, const Int3& bricks) {
  double share = 1;
  for (int d = 0; d < 3; ++d) {
    const double lo = std::clamp(parts.lo[d], 0.0, 1.0), hi = std::clamp(parts.hi[d], 0.0, 1.0);
    double most = 0;
    for (int i = 0; i < bricks[d]; ++i)
      most = std::max(most, std::min(hi, double(i + 1) / bricks[d]) - std::max(lo, double(i) / bricks[d]));
    share *= hi > lo ? most / (hi - lo) : 1.0;
  }
  return share;
}

int product(const Int3& b) {
  return b[0] * b[1] * b[2];
}

}  // namespace

bool script_allows(const PlannedParts& parts, int ranks) {
  int fixed = 1;
  bool all = true;
  for (int w : parts.wanted) w > 0 ? fixed *= w : all = false;
  return all ? fixed == ranks : ranks % fixed == 0;
}

Int3 planned_bricks(const PlannedParts& parts, int ranks) {
  if (ranks == product(parts.bricks)) return parts.bricks;
  const bool as_wanted = script_allows(parts, ranks);
  Int3 best{1, 1, ranks};
  double least = std::numeric_limits<double>::infinity();
  for (int a = 1; a <= ranks; ++a)
    for (int b = 1; ranks % a == 0 && b <= ranks / a; ++b) {
      if (ranks / a % b != 0) continue;
      const Int3 n{a, b, ranks / a / b};
      bool fits = true;
      for (int d = 0; d < 3; ++d) fits = fits && (!as_wanted || parts.wanted[d] == 0 || parts.wanted[d] == n[d]);
      if (!fits) continue;
      const auto& l = parts.length;
      double surface = l[0] * l[1] / n[0] / n[1] + l[1] * l[2] / n[1] / n[2] + l[0] * l[2] / n[0] / n[2];
      // Who may choose takes bricks that all hold as much.
      if (!as_wanted) surface *= share_of(parts, n);
      if (surface < least) least = surface, best = n;
    }
  return best;
}

double fullest_share(const PlannedParts& parts, int ranks) {
  constexpr double kTolerated = 1.1;  // where borders follow
  const double share = share_of(parts, planned_bricks(parts, ranks));
  return parts.follow ? std::min(share, kTolerated / ranks) : std::max(share, 1.0 / ranks);
}

double seconds_on(const PlannedRun& run, int ranks) {
  const int now = product(run.parts.bricks);
  if (ranks == now) return run.seconds();
  // What was measured on several ranks holds their messages and waits, too.
  const double measured = run.particle_seconds + run.fluid_seconds;
  const double lost = std::min(messages(run, run.parts.bricks, now), 0.7 * measured);
  const double work = measured > 0 ? 1 - lost / measured : 1.0;
  return work * (run.particle_seconds * particle_share(run, ranks) / particle_share(run, now) +
                 run.fluid_seconds * cell_share(run, ranks) / cell_share(run, now)) +
         messages(run, planned_bricks(run.parts, ranks), ranks) + run.other_seconds;
}

double bytes_on(const PlannedParts& parts, double empty, double most, int ranks) {
  const int now = product(parts.bricks);
  const auto share = [&](int n) { return std::max(fullest_share(parts, n), 1.0 / n); };
  return empty + std::max(0.0, most - empty) * share(ranks) / share(now);
}

}  // namespace twogrid
