// Optional models that a build can leave out (cmake -DTWOGRID_WITHOUT="hold;accuracy"), so that it can be measured that
// a model costs nothing while it is off: tests/bench/off_costs_nothing.py. A build without a model ignores its keyword.
#pragma once

namespace twogrid::compiled {

#ifdef TWOGRID_WITHOUT_HOLD
constexpr bool kHold = false;
#else
constexpr bool kHold = true;          ///< volume flux held between couplings
#endif
#ifdef TWOGRID_WITHOUT_HELD
constexpr bool kHeld = false;
#else
constexpr bool kHeld = true;          ///< particles that nothing moves
#endif
#ifdef TWOGRID_WITHOUT_ACCURACY
constexpr bool kAccuracy = false;
#else
constexpr bool kAccuracy = true;      ///< steps in time checked and chosen
#endif
#ifdef TWOGRID_WITHOUT_FORMULATION_A
constexpr bool kFormulationA = false;
#else
constexpr bool kFormulationA = true;  ///< pressure gradient force on particles
#endif
#ifdef TWOGRID_WITHOUT_POLYDISPERSE
constexpr bool kPolydisperse = false;
#else
constexpr bool kPolydisperse = true;  ///< local mean diameters
#endif
#ifdef TWOGRID_WITHOUT_GAP_FRICTION
constexpr bool kGapFriction = false;
#else
constexpr bool kGapFriction = true;
#endif
#ifdef TWOGRID_WITHOUT_FLOW_RATE
constexpr bool kFlowRate = false;
#else
constexpr bool kFlowRate = true;  ///< a given flow rate in a periodic direction
#endif

}  // namespace twogrid::compiled
