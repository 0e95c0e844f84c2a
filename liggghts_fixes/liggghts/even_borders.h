// Where to cut a direction so that as many particles lie in every part.
#pragma once

#include <vector>

namespace twogrid {

/// Positions (fractions of the length) of `parts` - 1 borders between parts with as many particles each, given the
/// counts in equal bins; no part is narrower than least. old: the present borders, 0 and 1 included; no border moves
/// beyond the old places of its neighbours. Returns all borders, 0 and 1 included.
std::vector<double> even_borders(const std::vector<long long>& count, const std::vector<double>& old, double least);

}  // namespace twogrid
