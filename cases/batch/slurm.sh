#!/bin/bash
# The body of every submit.slurm: one leg; when it was ended by a signal, the job is put back into the queue and goes on.
#   slurm.sh CASE [--done COMMAND] SCRIPT [--short|--long] [words ...]
#   CASE: the folder of the case. Results: CASE/out/job_ID (in an array job_ID_INDEX; out: as for ../run). COMMAND FOLDER: what follows when the script is done;
#   without it a folder with a case.sh is compared, drawn and reported as by ../run, and started on the job's ranks as by it.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here"/job.sh
job=$SLURM_JOB_ID
[ -z "${SLURM_ARRAY_JOB_ID:-}" ] || job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
set_up "$job" "${SLURM_NTASKS:-1}" "$@"
child=
trap '[ -z "$child" ] || kill -USR1 "$child" 2>/dev/null' USR1 TERM
"$here"/leg.sh "$folder" "$script" "${words[@]}" &
child=$!
code=0
wait "$child" || code=$?
while kill -0 "$child" 2>/dev/null; do
  code=0
  wait "$child" || code=$?
done
case $code in
  0) conclude ;;
  75 | 138 | 143)  # the latter: before leg.sh could heed signals
    echo "$folder: goes on in another leg"
    scontrol requeue "$job"  # ends this job here
    exit 75
    ;;
esac
exit "$code"
