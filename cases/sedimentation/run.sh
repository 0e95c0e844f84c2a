#!/bin/sh
# The sedimentation from a bare checkout to its pictures: installs what is missing, builds, runs, compares, draws.
#   run.sh [--short] [--ranks N] [-var NAME VALUE ...]
#   --short  one concentration in a lower column
#   -var     any of the choices at the top of in.sedimentation, such as -var dS 0.5e-3
exec "$(dirname "$0")"/../run sedimentation "$@"
