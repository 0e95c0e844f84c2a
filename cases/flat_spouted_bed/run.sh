#!/bin/sh
# The flat spouted bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  fewer grains on coarse cells for 0.2 s; --long: means over 6.8 s instead of 1.8 s
#   -var     any of the choices at the top of in.flat_spouted_bed, such as -var Ujet 30
exec "$(dirname "$0")"/../run flat_spouted_bed "$@"
