#!/bin/bash
# One leg of a run that takes several: begins the script, or goes on from its newest whole checkpoint.
#   leg.sh [-n RANKS] [-t SECONDS] FOLDER SCRIPT [words for twogrid ...]
#     -n  ranks; default: as many tasks as the batch job has
#     -t  ends the leg tidily after so long; where the batch system sends a signal before the limit, it isn't needed
#   FOLDER holds all of the run: a copy of the script as it was at the first leg, log, status.json, checkpoints, results, and legs.txt with
#   a line for each leg. The same folder goes on with the same run.
# Exit codes
#   0   the script is done
#   75  ended by a signal (the limit, preemption, -t): the next leg goes on
#   1   an error, told in FOLDER/log.liggghts and status.json; or two legs without a new checkpoint, which no third one would change
# SIGUSR1, SIGTERM and SIGINT end the leg: twogrid finishes its step, writes a checkpoint and ends with 128 + signal.
# $TWOGRID: the program, see ../program.sh; $TWOGRID_LAUNCHER: what starts ranks, see ../mpirun.sh.
set -u
cases=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
ranks=${SLURM_NTASKS:-${PBS_NP:-${NCPUS:-1}}} seconds=
while getopts n:t: option; do
  case $option in
    n) ranks=$OPTARG ;;
    t) seconds=$OPTARG ;;
    *) sed -n '2,17s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2 ;;
  esac
done
# A signal before the child is there is kept for it.
child= timer= asked=
trap 'asked=1; [ -z "$child" ] || kill -USR1 "$child" 2>/dev/null' USR1 TERM INT
shift $((OPTIND - 1))
[ $# -ge 2 ] || { sed -n '2,17s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
folder=$1 script=$2
shift 2
. "$cases"/program.sh
find_program || exit 1
name=$(basename "$script")
mkdir -p "$folder" && { [ -f "$folder/$name" ] || cp "$script" "$folder/$name"; } && cd "$folder" || exit 1

export TWOGRID_GRACE=${TWOGRID_GRACE:-20}
newest() { ls -d "$name".checkpoints/*_step_* 2>/dev/null | sort | tail -n 1; }
state() { sed -n 's/^  "state": "\(.*\)",$/\1/p' status.json 2>/dev/null; }

before=$(newest)
rm -f status.json
"$cases"/mpirun.sh "$ranks" "$program" -in "$name" -log log.liggghts -restart auto "$@" &
child=$!
if [ -n "$seconds" ]; then
  { sleep "$seconds"; kill -USR1 "$child"; } 2>/dev/null &
  timer=$!
fi
[ -z "$asked" ] || kill -USR1 "$child"
code=0
wait "$child" || code=$?
while kill -0 "$child" 2>/dev/null; do
  code=0
  wait "$child" || code=$?
done
if [ -n "$timer" ]; then
  pkill -P "$timer" 2>/dev/null
  kill "$timer" 2>/dev/null
fi

# Not every launcher hands on the code of its ranks: status.json has the last word on signals. One that still says running after a
# signal to this script is that of ranks which were killed before their time: the checkpoint before goes on.
result=1
case $code in
  0) result=0 ;;
  130 | 138 | 143) result=75 ;;
  *) case "$(state)" in "ended by signal "*) result=75 ;; running) [ -z "$asked" ] || result=75 ;; esac ;;
esac
after=$(newest)
gain=
[ "$result" != 75 ] || [ "$before" != "$after" ] || gain=", no gain"
echo "$(date -u +%FT%TZ) code $code, $(state), ${after:-no checkpoint}$gain" >>legs.txt
if [ "$(tail -n 2 legs.txt | grep -c ', no gain$')" = 2 ]; then
  echo "leg.sh: two legs without a new checkpoint of $folder/$name: they are too short for its set-up and one step" >&2
  result=1
fi
[ "$result" != 1 ] || echo "leg.sh: $folder: code $code; $(sed -n 's/^  "error": \(".*"\),$/\1/p' status.json 2>/dev/null)" >&2
exit "$result"
