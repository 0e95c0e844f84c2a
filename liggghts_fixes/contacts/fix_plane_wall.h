// fix wall/gran for a plane wall at rest with hooke/stiffness and tangential history: LIGGGHTS' own fix, its contacts
// evaluated by our kernel with the same results to the last bit. What the kernel doesn't serve is left to LIGGGHTS,
// step by step.
#pragma once

#include <fix_wall_gran.h>

#include <memory>
#include <string>
#include <vector>

#include "liggghts_fixes/contacts/contact_laws.h"

namespace twogrid {

class FixPlaneWall : public LAMMPS_NS::FixWallGran {
 public:
  FixPlaneWall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel, const PlaneWall& wall,
               const ContactSettings& settings);
  void init() override;

 protected:
  void post_force_primitive(int vflag) override;

 private:
  bool served() const;

  const ContactKernel& kernel_;
  PlaneWall wall_;
  ContactSettings settings_;
  std::unique_ptr<ContactLaws> laws_;
  std::vector<int> contacts_;
};

/// The fix if the kernel serves the wall that the words of the script describe, else null.
LAMMPS_NS::Fix* make_plane_wall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel);

}  // namespace twogrid
