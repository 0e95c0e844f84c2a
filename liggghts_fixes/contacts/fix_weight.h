// fix gravity by our kernel: the same forces as LIGGGHTS' own to the last bit.
#pragma once

#include <fix_gravity.h>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {

class FixWeight : public LAMMPS_NS::FixGravity {
 public:
  FixWeight(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel)
      : FixGravity(lammps, narg, arg), kernel_(kernel) {}
  void post_force(int vflag) override;
  /// Potential energy (J). LIGGGHTS sums it up at every step; here it is done when asked for. Collective.
  double compute_scalar() override;

 private:
  bool served() const;

  const ContactKernel& kernel_;
};

}  // namespace twogrid
