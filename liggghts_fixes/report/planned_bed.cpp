#include "liggghts_fixes/report/planned_bed.h"

#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"

namespace twogrid {

namespace {

/// Share that is carried at this velocity: none at that of minimum fluidisation, all from 1.5 times it on.
double carried(double u, double Umf) {
  return std::clamp((u / Umf - 1) / 0.5, 0.0, 1.0);
}

}  // namespace

double carried_share(const Settings& s, const FineGrid& grid, const SceneNumbers& n, const SettledBed& bed) {
  if (!(n.Umf > 0) || !(bed.section > 0) || !(n.U_bed > 0)) return -1;
  double inlets = 0, share = 0;
  for (int side = 0; side < 6; ++side) {
    const std::vector<PatchSize> sizes = patch_sizes(s.fluid, side, grid);
    for (std::size_t i = 0; i < s.fluid.side[side].size(); ++i) {
      const BoundaryCondition& c = s.fluid.side[side][i];
      if (c.kind != BoundaryKind::kInlet) continue;
      const double u = std::abs((c.velocity_now ? c.velocity_now() : c.velocity)[direction(side)]);
      const double part = sizes[i].open / bed.section;
      inlets += part;
      share += part * carried(u, n.Umf) * (part < 0.25 ? 3 : 1);
    }
  }
  // Narrow below, as a cone, or gas that comes through bodies: by what goes through the bed on the whole.
  if (inlets < 0.5) share = std::max(share, carried(n.U_bed, n.Umf));
  return std::min(1.0, share);
}

double planned_builds(const PlannedBed& bed, double skin, double dt) {
  return bed.share > 0 && skin > 0 ? std::min(1.0, 0.65 * bed.U_bed * dt / (0.5 * skin)) : 0.0;
}

double planned_contacts(double share, double measured, double falls, double seconds) {
  const double settled = std::max(measured, kSettledContacts);
  if (share >= 0) return share * kCarriedContacts + (1 - share) * settled;
  // A third of those that it will have, in the mean of the fall.
  const double part = seconds > 0 ? std::clamp(falls / seconds, 0.0, 1.0) : 0.0;
  return settled * (1 - part) + std::max(measured, settled / 3) * part;
}

}  // namespace twogrid
