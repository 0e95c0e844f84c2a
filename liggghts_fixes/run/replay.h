// A script that is read again by a run that goes on from a checkpoint: what it did before is not done again. While it is
// replayed, commands that write files of the moment keep still.
#pragma once

namespace twogrid {

bool replaying();
void set_replaying(bool on);

/// Whether this process was asked to go on with a run (-restart).
bool restarting();
void set_restarting(bool on);

}  // namespace twogrid
