#include "liggghts_fixes/liggghts/motion.h"

#include <fix_adapt.h>
#include <fix_lineforce.h>
#include <fix_move.h>
#include <fix_planeforce.h>
#include <fix_setforce.h>
#include <lammps.h>
#include <modify.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "liggghts_fixes/private_member.h"
#include "liggghts_fixes/script/words.h"

namespace {

using namespace LAMMPS_NS;

// What these fixes were told is private.
PRIVATE_MEMBER(MoveStyle, FixMove, int, mstyle);
PRIVATE_MEMBER(MoveLinearX, FixMove, int, vxflag);
PRIVATE_MEMBER(MoveLinearY, FixMove, int, vyflag);
PRIVATE_MEMBER(MoveLinearZ, FixMove, int, vzflag);
PRIVATE_MEMBER(MoveWiggleX, FixMove, int, axflag);
PRIVATE_MEMBER(MoveWiggleY, FixMove, int, ayflag);
PRIVATE_MEMBER(MoveWiggleZ, FixMove, int, azflag);
PRIVATE_MEMBER(MoveX, FixMove, char*, xvarstr);
PRIVATE_MEMBER(MoveY, FixMove, char*, yvarstr);
PRIVATE_MEMBER(MoveZ, FixMove, char*, zvarstr);
PRIVATE_MEMBER(MoveVX, FixMove, char*, vxvarstr);
PRIVATE_MEMBER(MoveVY, FixMove, char*, vyvarstr);
PRIVATE_MEMBER(MoveVZ, FixMove, char*, vzvarstr);
PRIVATE_MEMBER(ForceX, FixSetForce, int, xstyle);
PRIVATE_MEMBER(ForceY, FixSetForce, int, ystyle);
PRIVATE_MEMBER(ForceZ, FixSetForce, int, zstyle);
PRIVATE_MEMBER(ForceXName, FixSetForce, char*, xstr);
PRIVATE_MEMBER(ForceYName, FixSetForce, char*, ystr);
PRIVATE_MEMBER(ForceZName, FixSetForce, char*, zstr);
PRIVATE_MEMBER(ForceRegion, FixSetForce, char*, idregion);
PRIVATE_MEMBER(PlaneX, FixPlaneForce, double, xdir);
PRIVATE_MEMBER(PlaneY, FixPlaneForce, double, ydir);
PRIVATE_MEMBER(PlaneZ, FixPlaneForce, double, zdir);

}  // namespace

namespace twogrid {
namespace {

using Directions = std::array<bool, 3>;

/// Directions in which fix move prescribes the way; in the others it integrates as nve does.
Directions prescribed(const FixMove& m) {
  enum { kLinear, kWiggle, kRotate, kVariable };  // LIGGGHTS' order
  switch (m.*member(MoveStyle())) {
    case kLinear:
      return {m.*member(MoveLinearX()) != 0, m.*member(MoveLinearY()) != 0, m.*member(MoveLinearZ()) != 0};
    case kWiggle:
      return {m.*member(MoveWiggleX()) != 0, m.*member(MoveWiggleY()) != 0, m.*member(MoveWiggleZ()) != 0};
    case kVariable:
      return {m.*member(MoveX()) || m.*member(MoveVX()), m.*member(MoveY()) || m.*member(MoveVY()),
              m.*member(MoveZ()) || m.*member(MoveVZ())};
    default:
      return {true, true, true};
  }
}

/// The direction of x, y or z that a vector has. Refuses others.
int along(const Fix& fix, const double dir[3]) {
  for (int d = 0; d < 3; ++d)
    if (std::abs(std::abs(dir[d]) - 1) < 1e-12) return d;
  refuse("fix " + std::string(fix.id) + " " + fix.style,
         "the direction " + text(dir[0]) + " " + text(dir[1]) + " " + text(dir[2]) + " across those of the grid",
         "x, y or z: whether the fluid moves a particle is decided in these");
}

/// Directions in which a force is overwritten.
Directions overwritten(Fix& fix) {
  if (auto* line = dynamic_cast<FixLineForce*>(&fix)) {
    double dir[3];
    line->get_dir(dir);
    Directions held{true, true, true};
    held[along(fix, dir)] = false;
    return held;
  }
  if (auto* plane = dynamic_cast<FixPlaneForce*>(&fix)) {
    const double dir[3] = {plane->*member(PlaneX()), plane->*member(PlaneY()), plane->*member(PlaneZ())};
    Directions held{false, false, false};
    held[along(fix, dir)] = true;
    return held;
  }
  if (auto* set = dynamic_cast<FixSetForce*>(&fix)) {
    if (set->*member(ForceRegion()))
      refuse("fix " + std::string(fix.id) + " setforce", "a region, in which particles are held while they are there",
             "a group of its own for particles that are held (group ... region)");
    // A style is set by the fix's init() where a variable is named.
    return {set->*member(ForceXName()) || set->*member(ForceX()) != 0,
            set->*member(ForceYName()) || set->*member(ForceY()) != 0,
            set->*member(ForceZName()) || set->*member(ForceZ()) != 0};
  }
  return {false, false, true};  // enforce2d
}

/// From place `begin` on, of fixes that add forces and aren't ours; null: none.
const Fix* first_that_adds(const Modify& modify, int begin, const Fix& coupled) {
  for (int f = begin; f < modify.nfix; ++f) {
    const MotionKind kind = motion_kind(modify.fix[f]->style, false, false);
    if (modify.fix[f] != &coupled && (modify.fmask[f] & FixConst::POST_FORCE) && kind == MotionKind::kNone &&
        std::strncmp(modify.fix[f]->style, "heat/", 5) != 0)
      return modify.fix[f];
  }
  return nullptr;
}

}  // namespace

Motion find_motion(LAMMPS& lammps, const Fix& coupled) {
  Motion m;
  const Modify& modify = *lammps.modify;
  bool after = false;
  for (int f = 0; f < modify.nfix; ++f) {
    Fix& fix = *modify.fix[f];
    const std::string name = "fix " + std::string(fix.id) + " (" + fix.style + ")";
    after = after || &fix == &coupled;
    if (auto* adapt = dynamic_cast<FixAdapt*>(&fix)) m.grows = m.grows || adapt->diamflag != 0;
    // All particles belong to group all, whose bit is the first.
    const int groups = fix.groupbit & 1 ? ~0 : fix.groupbit;
    constexpr int kActs = FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE;
    switch (motion_kind(fix.style, fix.time_integrate != 0, (modify.fmask[f] & kActs) != 0)) {
      case MotionKind::kNone:
        break;
      case MotionKind::kUnknown:
        m.warnings.push_back(name +
                             " is of a style that is not known here and acts where integrators of motion do: it "
                             "is taken to move its particles by the forces on them, as nve/sphere does; where it "
                             "doesn't, their drag will be wrong");
        [[fallthrough]];
      case MotionKind::kIntegrates:
        for (int& g : m.moving) g |= groups;
        m.still = false;
        break;
      case MotionKind::kKeeps:
        for (int& g : m.fixed) g |= groups;
        m.still = false;
        break;
      case MotionKind::kPrescribes: {
        const Directions way = prescribed(dynamic_cast<FixMove&>(fix));
        for (int d = 0; d < 3; ++d) (way[d] ? m.fixed : m.moving)[d] |= groups;
        m.still = false;
        break;
      }
      case MotionKind::kFreezes:
        for (int d = 0; d < 3; ++d) m.frozen[d] |= groups, m.fixed[d] |= groups;
        break;
      case MotionKind::kSetsForce: {
        const Directions held = overwritten(fix);
        for (int d = 0; d < 3; ++d)
          if (held[d]) {
            m.fixed[d] |= groups;
            if (!after) m.frozen[d] |= groups;  // it can't take away what is added later
          }
        const Fix* adds = after ? nullptr : first_that_adds(modify, f + 1, coupled);
        if (adds)
          m.warnings.push_back(name + " sets forces before fix " + adds->id + " (" + adds->style +
                               ") adds its own, and the fluid's drag is left out where a force is set: write " +
                               fix.id + " behind all fixes that add forces if its particles are to be held");
        break;
      }
      case MotionKind::kShares:
        m.warnings.push_back(name +
                             " shares the forces of its particles out among them: what each of them receives from "
                             "the fluid is right in the sum only");
        break;
    }
  }
  m.still = m.still && !m.grows;
  return m;
}

}  // namespace twogrid
