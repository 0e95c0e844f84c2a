// What is checked of a whole script, and what it leaves to the box. Pure functions: no LIGGGHTS, no MPI. All throw
// std::invalid_argument with one sentence that holds the keyword, what was found and what is wanted.
#pragma once

#include <array>

#include "cfd/grid/grid.h"
#include "liggghts_fixes/script/script.h"

namespace twogrid {

/// Fills in what the box says (domain, periodic sides) and checks what concerns several keywords: domain inside the
/// box, sides of periodic directions, lengths against cells, and all that FluidSettings::check looks at.
void complete(Script& script, const BoxFacts& box);

/// LIGGGHTS' boundary codes (0 p, 1 f, 2 s, 3 m; [direction][lo, hi]): s and m move the box at every rebuild and are
/// refused, with the line to write instead.
void check_box_boundary(const int boundary[3][2]);

/// The fine grid of complete settings.
FineGrid fine_grid(const Settings& settings, const std::array<bool, 3>& periodic);
/// Directions whose two sides are periodic.
std::array<bool, 3> periodic_directions(const FluidSettings& fluid);

}  // namespace twogrid
