// On which side of a line in the plane a point lies, exactly.
#pragma once

#include <array>

namespace twogrid {

/// Sign of (b - a) x (p - a): 1 where p lies to the left of the way from a to b, 0 on the line. Exact, unless numbers
/// overflow or vanish.
int turn(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& p);

}  // namespace twogrid
