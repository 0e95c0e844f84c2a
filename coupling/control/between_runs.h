// The particles' columns between two runs, in which commands may move particles and change their mass and size.
#pragma once

#include "coupling/forces/step_forces.h"
#include "coupling/particles/particles.h"

namespace twogrid {

/// A run has ended: kPosition becomes a difference to x, mass and radius are noted. Local.
void note_columns(Particles& p);
/// The next begins: the reverse. Returns the volume by which commands have made this rank's particles larger (m3). Local.
double take_up_columns(Particles& p, const StepForces& forces);

}  // namespace twogrid
