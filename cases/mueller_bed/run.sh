#!/bin/sh
# The bed of Mueller et al. from a bare checkout to its verdict: installs what is missing, builds, runs, compares, draws.
#   run.sh [--short] [-var NAME VALUE ...]
#   --short  0.7 s on a coarse grid with soft contacts instead of 12 s: shows that all works, not how good it is
#   -var     any of the choices at the top of in.mueller_bed, such as -var U 0.6
# The full run takes 40 minutes on one core; ranks: as many as there are cores, at most 4, side by side.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
short= verdict=
if [ "${1:-}" = --short ]; then
  short="-var tend 0.7 -var tavg 0.35 -var tframe 0.01 -var kn 50 -var dt 2e-5 -var every 5 -var nx 12 -var ny 2 -var nz 32 -var rx 1 -var ry 1 -var rz 1"
  verdict="--no-verdict --from 0.35"
  shift
fi
"$here"/../setup.sh
"$here"/../build.sh twogrid

name=run${short:+_short}
for word in "$@"; do
  case $word in -var) ;; *) name="${name}_$(printf %s "$word" | tr '/ ' '__')" ;; esac
done
out="$here/out/$name"
mkdir -p "$out"
ranks=$(nproc)
[ "$ranks" -le 4 ] || ranks=4
[ -z "$short" ] || ranks=1

echo "mueller bed: $ranks ranks, results in $out"
rm -f "$out"/finished
{ "$here"/../mpirun.sh "$ranks" "$here"/../../build/twogrid -in "$here"/in.mueller_bed -log "$out"/log.liggghts \
    -var out "$out" -var px "$ranks" $short "$@" && touch "$out"/finished; } 2>&1 |
  grep --line-buffered -E "^twogrid: |^WARNING: fix|^ERROR" || true
[ -f "$out"/finished ] || { echo "the run did not come to its end, see $out/log.liggghts" >&2; exit 1; }
exec "$here"/compare.py "$out" $verdict
