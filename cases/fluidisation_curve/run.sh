#!/bin/sh
# Sets up, builds, ramps the gas through minimum fluidisation and back, compares and draws. Options (-var Umax 0.4 ...)
# go to the script. About half a minute of computing.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
"$here"/../setup.sh
"$here"/../build.sh twogrid
out="$here/out"
mkdir -p "$out"
"$here"/../mpirun.sh 1 "$here"/../../build/twogrid -in "$here"/in.fluidisation_curve -var out "$out" -log "$out"/log.liggghts "$@"
exec "$here"/compare.py "$out"
