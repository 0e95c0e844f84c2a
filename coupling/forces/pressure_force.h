// The pressure gradient's force as a force of its own, V_p (R + D/eps): R the undisturbed flow's (undisturbed_force.h),
// read in formulation A; D/eps the gradient that balances the drag (mean_motion.h).
//
// Formulation B leaves -V_p grad p out and divides the drag by eps instead: D/eps gives every particle the same share of
// its own drag, if all are of one size. Where sizes differ it doesn't, and the force is b_p (u - v) + V_p D/eps there
// too.
#pragma once

#include <vector>

#include "coupling/forces/mean_motion.h"
#include "coupling/particles/particles.h"

namespace twogrid {

/// There is none any longer. Local.
void clear_pressure_force(Particles& p, const std::vector<int>& who);

/// Adds V_p D/eps to kPressureForce, or sets it where no R has been read; notes b_tot in kResponse. After
/// motion.couple() with drag. Local.
void add_pressure_of_drag(Particles& p, const std::vector<int>& who, MeanMotion& motion, bool residual_read);

}  // namespace twogrid
