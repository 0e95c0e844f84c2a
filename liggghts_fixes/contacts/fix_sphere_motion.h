// fix nve/sphere by our kernel: the same results as LIGGGHTS' own to the last bit. A particle whose position is not a
// number ends the run by a sentence, also where there is no fluid to find it.
#pragma once

#include <fix_nve_sphere.h>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace twogrid {

class FixSphereMotion : public LAMMPS_NS::FixNVESphere {
 public:
  FixSphereMotion(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg, const ContactKernel& kernel)
      : FixNVESphere(lammps, narg, arg), kernel_(kernel) {}
  int setmask() override;
  void setup_pre_exchange() override { pre_exchange(); }
  void pre_exchange() override;
  void initial_integrate(int vflag) override;
  void final_integrate() override;

 private:
  bool served() const;
  void half_step(double dt);

  const ContactKernel& kernel_;
};

}  // namespace twogrid
