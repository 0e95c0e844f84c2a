#!/bin/sh
# Runs every study found here and sums them up (results.md, error_cost.png). Finished runs are kept.
#   run.sh           all runs; other words go to sweep.py (-j N)
#   run.sh --short   a few runs of each study, in a scratch folder, compared with its table.csv; some 15 s a study
# $TWOGRID: the executable; without it build/twogrid of a checkout is built, or the installed one taken. In an installation results lie
#   in ./out/studies/NAME, and are not summed up.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cases=$(cd "$here/.." && pwd)
. "$cases"/program.sh
find_program --build || exit 1
failed=
if [ "${1:-}" = --short ]; then
  shift
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  for study in "$here"/*/study.toml; do
    grep -q '^\[short' "$study" || continue
    folder=$(dirname "$study")
    "$here"/../sweep.py "$folder" --short --out "$scratch/$(basename "$folder")" "$@" || failed="$failed $(basename "$folder")"
  done
  [ -z "$failed" ] || { echo "FAIL:$failed"; exit 1; }
  exit 0
fi
for study in "$here"/*/study.toml; do
  folder=$(dirname "$study")
  "$here"/../sweep.py "$folder" "$@" || failed="$failed $(basename "$folder")"
done
[ -n "$installed" ] || "$here"/summary.py
[ -z "$failed" ] || { echo "did not run:$failed"; exit 1; }
