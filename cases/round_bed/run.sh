#!/bin/sh
# The round bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --long   5 s instead of 2 s of gas, means from 1 s on; --short: a thin bed for 0.24 s
#   -var     any of the choices at the top of in.round_bed, such as -var U 1.2 -var nx 60
exec "$(dirname "$0")"/../run round_bed "$@"
