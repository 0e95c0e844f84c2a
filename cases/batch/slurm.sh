#!/bin/bash
# The body of every submit.slurm: one leg; when it was ended by a signal, the job is put back into the queue and goes on.
#   slurm.sh CASE [--done COMMAND] SCRIPT [words ...]
#   CASE: the case's folder. Results: CASE/out/job_ID (in an array job_ID_INDEX). COMMAND FOLDER: what follows when the script is done.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
case=$1
shift
finish=
if [ "$1" = --done ]; then
  finish=$2
  shift 2
fi
job=$SLURM_JOB_ID
[ -z "${SLURM_ARRAY_JOB_ID:-}" ] || job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
folder=$case/out/job_$job
script=$1
shift
child=
trap '[ -z "$child" ] || kill -USR1 "$child" 2>/dev/null' USR1 TERM
"$here"/leg.sh "$folder" "$script" "$@" &
child=$!
code=0
wait "$child" || code=$?
while kill -0 "$child" 2>/dev/null; do
  code=0
  wait "$child" || code=$?
done
case $code in
  0) [ -z "$finish" ] || exec "$finish" "$folder" ;;
  75 | 138 | 143)  # the latter: before leg.sh could heed signals
    echo "$folder: goes on in another leg"
    scontrol requeue "$job"  # ends this job here
    exit 75
    ;;
esac
exit "$code"
