# What slurm.sh and pbs.sh share; for `.`, with $here, this folder.

# set_up JOB RANKS CASE [--done COMMAND] SCRIPT [--short|--long] [words ...]: sets folder, script, words; has the case prepare its folder.
set_up() {
  local ranks=$2 word
  local job=job_$1
  case=$3 folder=$3/out/$job finish= mode=
  shift 3
  if [ "$1" = --done ]; then
    finish=$2
    shift 2
  fi
  script=$1
  shift
  words=()
  for word in "$@"; do
    case $word in --short | --long) mode=$word ;; *) words+=("$word") ;; esac
  done
  [ -f "$case/case.sh" ] || return 0
  case=$(cd "$case" && pwd) cases=$(cd "$here/.." && pwd)
  folder=$(. "$cases"/case_words.sh && results_folder)/$job
  local more
  more=$(. "$cases"/case_words.sh && mode_words "$mode" && ranks_words "$ranks") || exit 2
  words+=($more)
  mkdir -p "$folder"
  (out=$(cd "$folder" && pwd) && . "$cases"/case_words.sh && prepare) || exit 1
}

# What follows when the script is done.
conclude() {
  [ -z "$finish" ] || exec "$finish" "$folder"
  [ ! -f "$case/case.sh" ] || exec "$cases/run" "$case" $mode --out "$folder" --compare
  exit 0
}
