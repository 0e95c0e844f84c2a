# What run and batch/*.sh share; for `.`, with $cases, this folder, and $case, that of the case.
#
# What a case.sh may set:
#   title         of the case
#   what against  a line each for cases/list: what it is, what it is compared with
#   time_short time_run time_long memory   for cases/list, as measured
#   most          ranks that it can use
#   first second  variables of in.NAME for ranks in a first direction and a second one, which is used with an even number from 4 on
#   short long    words for the program in these modes
#   compare_short words for compare.py after a short run
#   show          what is shown of what the program says
#   prepare       writes what in.NAME reads into the folder $out, which the run has as its own
#   finish        compares and draws; $out, and $compare_short after a short run
name=${case##*/}
title=$name what= against= time_short= time_run= time_long= memory= most=8 first=px second= short= long= compare_short= show='^twogrid: |^WARNING: (fix|Particle insertion)|^ERROR'
prepare() { :; }
finish() { "$case"/compare.py "$out" "$@"; }
. "$case"/case.sh
. "$cases"/program.sh

# Folder of a case's results: $TWOGRID_OUT/NAME; without it out beside the case, or out/NAME where one stands if the case is
# one of an installation's, which all users share, or in a folder that may not be written.
results_folder() {
  if [ -n "${TWOGRID_OUT:-}" ]; then
    echo "$TWOGRID_OUT/$name"
  elif [ -w "$case" ] && { [ -z "$installed" ] || [ "${case#"$cases"/}" = "$case" ]; }; then
    echo "$case/out"
  else
    echo "$PWD/out/$name"
  fi
}

# What stands first holds, of several -var of one name: the user's words come before these.
ranks_words() {  # RANKS
  n1=$1 n2=1
  if [ -n "$second" ] && [ "$1" -ge 4 ] && [ $(($1 % 2)) -eq 0 ]; then n1=$(($1 / 2)) n2=2; fi
  echo "${first:+-var $first $n1} ${second:+-var $second $n2}"
}
mode_words() {  # --short, --long or nothing
  case $1 in
    --short) [ -n "$short" ] || { echo "$name has no short mode" >&2; return 2; }; echo "$short" ;;
    --long) [ -n "$long" ] || { echo "$name has no long mode" >&2; return 2; }; echo "$long" ;;
  esac
}
