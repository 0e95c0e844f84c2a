// What a number of a script may be at most, by its quantity. Wide enough for any flow of particles; what lies outside is a
// slip of the pen, a wrong unit or a variable that went astray, and would be computed with until something overflows.
#pragma once

namespace twogrid {

struct Range {
  double least, most;
};

constexpr Range kDensities{1e-6, 1e6};            ///< kg/m3
constexpr Range kViscosities{1e-15, 1e9};         ///< Pa s
constexpr Range kVelocities{-1e6, 1e6};           ///< m/s
constexpr Range kCoordinates{-1e6, 1e6};          ///< m
constexpr Range kLengths{1e-12, 1e6};             ///< m
constexpr Range kPressures{-1e12, 1e12};          ///< Pa
constexpr Range kPressureGradients{-1e12, 1e12};  ///< Pa/m
constexpr Range kTimes{0, 1e9};                   ///< s
constexpr Range kFluidSteps{1e-15, 1e6};          ///< s
constexpr Range kCheckpointTimes{1e-3, 1e9};      ///< s, by the clock
constexpr Range kCourantNumbers{1e-12, 1};
constexpr Range kTolerances{1e-15, 0.1};
constexpr Range kErrors{1e-4, 0.5};          ///< of means, relative
constexpr Range kVoidFractions{0.01, 0.99};  ///< smallest of a cell
constexpr Range kFactors{-1e6, 1e6};         ///< on a velocity
constexpr double kMostStretch = 1e6;         ///< widest cell over narrowest, of a direction

}  // namespace twogrid
