#!/bin/sh
# The NETL-like bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  a thin slice of it for 0.2 s; --long: means over 6.5 s instead of 1.5 s
#   -var     any of the choices at the top of in.netl_bed, such as -var U 3.28
exec "$(dirname "$0")"/../run netl_bed "$@"
