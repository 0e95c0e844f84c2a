#!/bin/sh
# The round bed from a bare checkout to its pictures: installs what is missing, builds, runs on all cores, compares,
# draws.   run.sh [--long] [-var NAME VALUE ...]
#   --long   5 s instead of 2 s of gas, means from 1 s on
#   -var     any of the choices at the top of in.round_bed, such as -var U 1.2 -var nx 60
set -eu
here=$(cd "$(dirname "$0")" && pwd)
long=
if [ "${1:-}" = --long ]; then
  long="-var tend 5.0 -var tavg 1.0"
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
"$here"/make_stl.py "$out"/vessel.stl
ranks=$(nproc)
[ "$ranks" -le 8 ] || ranks=8
# Ranks side by side, and behind each other from 4 on; with an odd number all side by side.
px=$ranks py=1
if [ "$ranks" -ge 4 ] && [ $((ranks % 2)) -eq 0 ]; then px=$((ranks / 2)) py=2; fi

echo "round bed: $ranks ranks, results in $out"
rm -f "$out"/finished
{ "$here"/../mpirun.sh "$ranks" "$here"/../../build/twogrid -in "$here"/in.round_bed -log "$out"/log.liggghts \
    -var out "$out" -var stl "$out"/vessel.stl -var px $px -var py $py $long "$@" && touch "$out"/finished; } 2>&1 |
  grep --line-buffered -E "^twogrid: |^WARNING: fix|^ERROR" || true
[ -f "$out"/finished ] || { echo "the run did not come to its end, see $out/log.liggghts" >&2; exit 1; }
exec "$here"/compare.py "$out"
