#!/bin/sh
# The first bed from a bare checkout to its pictures: installs what is missing, builds, runs on two ranks, draws.
# Results lie in out/. Some 10 s of computing.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
"$here"/../setup.sh
"$here"/../build.sh twogrid
mkdir -p "$here"/out
cd "$here"/out
"$here"/../mpirun.sh 2 "$here"/../../build/twogrid -in "$here"/in.first_bed -log log.liggghts "$@"
exec "$here"/../plot_fields.py first_bed.h5 --out . --heights 10 20 30
