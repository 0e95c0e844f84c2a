// fix nve/sphere by our kernel: the same results as LIGGGHTS' own to the last bit.
#pragma once

#include <fix_nve_sphere.h>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {

class FixSphereMotion : public LAMMPS_NS::FixNVESphere {
 public:
  FixSphereMotion(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel)
      : FixNVESphere(lammps, narg, arg), kernel_(kernel) {}
  void initial_integrate(int vflag) override;
  void final_integrate() override;

 private:
  bool served() const;
  void half_step(double dt);

  const ContactKernel& kernel_;
};

}  // namespace twogrid
