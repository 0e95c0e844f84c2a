#!/bin/bash
# A run in legs without a batch system: leg after leg until it is done, stopped at an error and at legs that don't get on.
#   loop.sh [-n RANKS] [-t SECONDS] FOLDER SCRIPT [words for twogrid ...]      see leg.sh
# A signal to this script ends the leg in hand and the loop, with code 75: the same command goes on.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
child= ended=
trap 'ended=1; [ -z "$child" ] || kill -USR1 "$child" 2>/dev/null' USR1 TERM INT
while :; do
  "$here"/leg.sh "$@" &
  child=$!
  code=0
  wait "$child" || code=$?
  while kill -0 "$child" 2>/dev/null; do
    code=0
    wait "$child" || code=$?
  done
  [ "$code" = 75 ] && [ -z "$ended" ] || exit "$code"
done
