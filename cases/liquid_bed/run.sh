#!/bin/sh
# The liquid bed from a bare checkout to its pictures: installs what is missing, builds, runs, compares, draws.
#   run.sh [--short|--long] [--ranks N] [-var NAME VALUE ...]
#   --short  two velocities, 600 grains; --long: three times as long at each velocity
#   -var     any of the choices at the top of in.liquid_bed, such as -var law difelice
exec "$(dirname "$0")"/../run liquid_bed "$@"
