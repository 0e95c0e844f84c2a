#!/bin/bash
# The body of every submit.pbs: one leg; when it was ended by its time, the same script is submitted once more, to run after this job.
#   pbs.sh CASE SUBMIT SECONDS RANKS [--done COMMAND] SCRIPT [--short|--long] [words ...]      as slurm.sh
#   Results: CASE/out/job_ID, with the ID of the first job ($TWOGRID_RUN hands it on). PBS itself runs a job again that it has lost (-r y):
#   it goes on from its newest checkpoint likewise.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here"/job.sh
submit=$2 seconds=$3 ranks=$4 at=$1
shift 4
run=${TWOGRID_RUN:-${PBS_JOBID%%.*}}
set_up "$run" "$ranks" "$at" "$@"
code=0
# In the foreground: PBS sends its signals to all processes of the job.
"$here"/leg.sh -n "$ranks" -t "$seconds" "$folder" "$script" "${words[@]}" || code=$?
case $code in
  0) conclude ;;
  75)
    echo "$folder: goes on in another leg"
    cd "$PBS_O_WORKDIR" && exec qsub -W "depend=afterany:$PBS_JOBID" -v "TWOGRID_RUN=$run" "$submit"
    ;;
esac
exit "$code"
