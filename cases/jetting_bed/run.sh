#!/bin/sh
# The jetting bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares,
# draws.   run.sh [--long] [-var NAME VALUE ...]
#   --long   6 s instead of 0.75 s of gas, means from 1 s on
#   -var     any of the choices at the top of in.jetting_bed, such as -var jets 3 -var U 9
set -eu
here=$(cd "$(dirname "$0")" && pwd)
long=
if [ "${1:-}" = --long ]; then
  long="-var tend 6.0 -var tavg 1.0"
  shift
fi
"$here"/../setup.sh
"$here"/../build.sh twogrid

name=run
for word in $long "$@"; do
  case $word in -var) ;; *) name="${name}_$word" ;; esac
done
out="$here/out/$name"
mkdir -p "$out"
ranks=$(nproc)
[ "$ranks" -le 8 ] || ranks=8
# Ranks side by side, and on top of each other from 4 on; with an odd number all side by side.
px=$ranks pz=1
if [ "$ranks" -ge 4 ] && [ $((ranks % 2)) -eq 0 ]; then px=$((ranks / 2)) pz=2; fi

echo "jetting bed: $ranks ranks, results in $out"
rm -f "$out"/finished
{ "$here"/../mpirun.sh "$ranks" "$here"/../../build/twogrid -in "$here"/in.jetting_bed -log "$out"/log.liggghts \
    -var out "$out" -var px $px -var pz $pz $long "$@" && touch "$out"/finished; } 2>&1 |
  grep --line-buffered -E "^twogrid: |^WARNING: fix|^ERROR" || true
[ -f "$out"/finished ] || { echo "the run did not come to its end, see $out/log.liggghts" >&2; exit 1; }
exec "$here"/compare.py "$out"
