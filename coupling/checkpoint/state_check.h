// Whether what a checkpoint holds can be a state at all. A file whose checksum is right holds what was written; but it may
// come from a program that went astray, or from an editor of HDF5 files, and what is read into a state is computed with
// and indexed by.
#pragma once

#include <string>

#include "cfd/grid/box.h"

namespace twogrid {

struct FluidState;
struct CouplingState;

/// What the values of an entry, "/group/name", must lie in.
struct EntryRange {
  double least, most;
  bool holds(double value) const { return value >= least && value <= most; }  ///< not so for NaN
};
EntryRange range_of(const std::string& path);

/// What an array's size hangs on.
struct StateShape {
  Box own_cells, own_nodes;
  bool one_way;  ///< setting: the fluid doesn't feel the particles
};

/// Arrays that numbers or settings promise and that are not there, or have another size than they can have: a sentence's
/// part; empty: none. Local.
std::string broken_promise(const FluidState& fluid, const CouplingState& coupling, const StateShape& shape);

}  // namespace twogrid
