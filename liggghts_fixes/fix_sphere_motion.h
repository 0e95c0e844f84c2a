// fix nve/sphere with leaner loops: the same results as LIGGGHTS' own to the last bit.
#pragma once

#include <fix_nve_sphere.h>

namespace twogrid {

class FixSphereMotion : public LAMMPS_NS::FixNVESphere {
 public:
  FixSphereMotion(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : FixNVESphere(lammps, narg, arg) {}
  void initial_integrate(int vflag) override;
  void final_integrate() override;

 private:
  bool served() const;
  template <bool kDrift>
  void kick();
};

}  // namespace twogrid
