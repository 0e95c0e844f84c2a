#!/bin/sh
# The spouted bed with slot from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  a thin slice of it for 0.2 s; --long: means over 6.8 s instead of 1.8 s
#   -var     any of the choices at the top of in.slot_spouted_bed, such as -var Ujet 25
exec "$(dirname "$0")"/../run slot_spouted_bed "$@"
