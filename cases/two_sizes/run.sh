#!/bin/sh
# The beds of two sizes from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short] [--ranks N] [-var NAME VALUE ...]
#   --short  fewer grains for 0.1 s each
#   -var     any of the choices at the top of in.two_sizes, such as -var law beetstra/poly
exec "$(dirname "$0")"/../run two_sizes "$@"
