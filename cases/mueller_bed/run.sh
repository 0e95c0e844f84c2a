#!/bin/sh
# The bed of Mueller et al. from a bare checkout to its verdict: installs what is missing, builds, runs, compares, draws.
#   run.sh [--short] [--ranks N] [-var NAME VALUE ...]
#   --short  0.7 s on a coarse grid with soft contacts instead of 12 s: shows that all works, not how good it is
#   -var     any of the choices at the top of in.mueller_bed, such as -var U 0.6
# The full run takes 40 minutes on one core; ranks: as many as there are cores, at most 4, side by side.
exec "$(dirname "$0")"/../run mueller_bed "$@"
