#!/bin/sh
# The tube bank from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  fewer grains on coarse cells for 0.14 s; --long: 6 s instead of 2 s of gas, means from 1 s on
#   -var     any of the choices at the top of in.tube_bank, such as -var U 1.0
exec "$(dirname "$0")"/../run tube_bank "$@"
