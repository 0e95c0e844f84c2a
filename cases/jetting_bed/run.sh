#!/bin/sh
# The jetting bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --long   6 s instead of 0.75 s of gas, means from 1 s on; --short: a thin bed for 0.08 s
#   -var     any of the choices at the top of in.jetting_bed, such as -var jets 3 -var U 9
exec "$(dirname "$0")"/../run jetting_bed "$@"
