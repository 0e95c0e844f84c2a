#!/bin/bash
# Every batch script of the cases: valid to the shell, names files that exist, and, where a Slurm answers, accepted by
# sbatch. Without it a batch script could rot unseen, as no other test reads it.
set -u
top=$(cd "$(dirname "$0")/../.." && pwd)
failed=0
check() {  # check WHAT COMMAND...
  local what=$1
  shift
  if "$@" >/tmp/batch_script.$$ 2>&1; then
    echo "ok   $what"
  else
    echo "FAIL $what:"
    cat /tmp/batch_script.$$
    failed=1
  fi
  rm -f /tmp/batch_script.$$
}

scripts=("$top"/cases/*/submit.slurm)
for script in "${scripts[@]}"; do
  name=${script#"$top"/}
  check "$name is valid to the shell" bash -n "$script"
  for option in job-name ntasks time output; do
    check "$name asks for --$option" grep -q "^#SBATCH --$option=" "$script"
  done
  for file in $(grep -o 'SLURM_SUBMIT_DIR/[a-z_.]*' "$script" | sed 's/.*\///' | grep -E '^(in\.|.*\.py$)' | sort -u); do
    check "$name: $file lies beside it" test -f "$(dirname "$script")/$file"
  done
  # The script's own lines, with a launcher that only counts: does it start the program as it should?
  work=$(mktemp -d)
  mkdir "$work/case"
  printf '#!/bin/sh\nexit 0\n' >"$work/case/compare.py"
  printf '#!/bin/sh\necho "$@" >"%s/started"\n' "$work" >"$work/launcher"
  chmod +x "$work/case/compare.py" "$work/launcher"
  check "$name runs to its end with a launcher that starts nothing" env SLURM_SUBMIT_DIR="$work/case" SLURM_JOB_ID=1 \
    SLURM_NTASKS=4 LAUNCHER="$work/launcher" bash "$script" -var jets 2
  check "$name hands on its words" grep -q -- "-in .*/in\..* -var jets 2" "$work/started"
  rm -rf "$work"
  if command -v sinfo >/dev/null && [ -n "$(timeout 20 sinfo -h -o %P 2>/dev/null)" ]; then
    check "$name is accepted by sbatch" timeout 60 sbatch --test-only "$script"
  else
    echo "     no Slurm answers here: $name is not put to sbatch"
  fi
done
exit $failed
