// SIGINT and SIGTERM end a run cleanly: a flag is set, which fix twogrid reduces over the ranks at couplings.
#pragma once

namespace twogrid {

/// Installs the handlers. A second signal ends the process at once.
void install_signal_handlers();
/// While no fix twogrid listens (+1 when one is made, -1 when it goes), LIGGGHTS' own handler takes the signals.
void add_signal_listener(int change);
/// Number of the first signal that came, or 0. This rank's only.
int signal_seen();

}  // namespace twogrid
