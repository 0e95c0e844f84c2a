#!/bin/sh
# The spouted cone from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  fewer grains on coarse cells for 0.3 s; --long: means over 2.8 s instead of 0.6 s
#   -var     any of the choices at the top of in.spouted_cone, such as -var U 10 -var n 30 -var nz 60
exec "$(dirname "$0")"/../run spouted_cone "$@"
