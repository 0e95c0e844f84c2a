// What a script says of contacts by hooke/stiffness and tangential history, for our kernel: LIGGGHTS' settings and
// material tables.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// Switches of LIGGGHTS' contact models that change the force.
struct ContactSettings {
  bool absolute_damping = false, tangential_damping = true, limit_force = false;
  std::string unknown;  ///< a switch that is on, or a word, that the kernel doesn't serve
};
/// words: pairs of switch and on or off.
ContactSettings read_contact_settings(const std::vector<std::string>& words);

class ContactLaws {
 public:
  /// Reads LIGGGHTS' material tables, which its own model must have asked for before, for this run. Types that nothing
  /// uses in it have laws of zeros.
  ContactLaws(LAMMPS_NS::LAMMPS& lammps, const ContactSettings& settings);
  /// For this step; frozen: bits of particles of infinite mass.
  ContactStep step(LAMMPS_NS::LAMMPS& lammps, bool advance, int frozen) const;

 private:
  ContactSettings settings_;
  int types_;
  bool one_;                     // all pairs of types alike
  std::vector<ContactLaw> law_;  // [types][types], from 0
};

/// LIGGGHTS' particles as the kernel sees them.
Spheres spheres(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
