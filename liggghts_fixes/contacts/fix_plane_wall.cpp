#include "liggghts_fixes/contacts/fix_plane_wall.h"

#include <atom.h>
#include <fix_property_atom.h>
#include <lammps.h>
#include <neighbor.h>
#include <primitive_wall.h>

#include <algorithm>
#include <cstdlib>

namespace twogrid {

using namespace LAMMPS_NS;

FixPlaneWall::FixPlaneWall(LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel, const PlaneWall& wall,
                           const ContactSettings& settings)
    : FixWallGran(lammps, narg, arg), kernel_(kernel), wall_(wall), settings_(settings) {}

void FixPlaneWall::init() {
  FixWallGran::init();
  laws_.reset();
}

bool FixPlaneWall::served() const {
  return atom->sphere_flag && !fix_rigid_ && !addflag_ && computeflag_ && !store_force_ && !store_force_contact_ &&
         !store_force_contact_stress_ && !fix_sum_normal_force_ && !fix_store_multicontact_data_ &&
         !heattransfer_flag_ && dnum_ == 3 && neighbor->contactDistanceFactor == 1.0 &&
         atom->nlocal + atom->nghost < atom->nmax;
}

void FixPlaneWall::post_force_primitive(int vflag) {
  if (!served()) {
    FixWallGran::post_force_primitive(vflag);
    return;
  }
  if (!laws_) laws_ = std::make_unique<ContactLaws>(*lmp, settings_);
  wall_.group = groupbit;
  wall_.reach = cutneighmax_;
  int* near = nullptr;
  const int n = primitiveWall_->getNeighbors(near);
  if (contacts_.size() < std::size_t(n) + 1) contacts_.resize(2 * n + 1);
  // Particles of infinite mass play no part: a wall's effective mass is the particle's.
  kernel_.wall_forces(spheres(*lmp), laws_->step(*lmp, shearupdate_ != 0, 0), wall_, near, n,
                      fix_history_primitive_->array_atom, contacts_.data());
}

Fix* make_plane_wall(LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel) {
  // ID group wall/gran model hooke/stiffness tangential history primitive type T PLANE POSITION [switches]
  const std::vector<std::string> words(arg, arg + narg);
  const std::vector<std::string> before{"model", "hooke/stiffness", "tangential", "history", "primitive", "type"};
  const std::vector<std::string> planes{"xplane", "yplane", "zplane"};
  constexpr long kFirst = 3, kType = 9, kSwitches = 12;
  if (narg < kSwitches || !std::equal(before.begin(), before.end(), words.begin() + kFirst)) return nullptr;
  const long normal = std::find(planes.begin(), planes.end(), words[kType + 1]) - planes.begin();
  const ContactSettings settings = read_contact_settings({words.begin() + kSwitches, words.end()});
  if (normal == 3 || !settings.unknown.empty()) return nullptr;
  const PlaneWall wall{int(normal), std::atof(words[kType + 2].c_str()), std::atoi(words[kType].c_str()), 0, 0};
  return new FixPlaneWall(lammps, narg, arg, kernel, wall, settings);
}

}  // namespace twogrid
