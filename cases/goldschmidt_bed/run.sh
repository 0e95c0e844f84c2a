#!/bin/sh
# The Goldschmidt bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  fewer grains on coarse cells for 0.25 s; --long: means over 14 s instead of 4 s
#   -var     any of the choices at the top of in.goldschmidt_bed, such as -var U 2.5
exec "$(dirname "$0")"/../run goldschmidt_bed "$@"
