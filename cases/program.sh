# For `.`, with $cases, this folder: find_program sets $program, the path of the program that the scripts run: $TWOGRID; without it that
# of the installation whose share/twogrid/cases this is; in a checkout build/twogrid, with --build after setup.sh and build.sh.
installed=
[ -f "$cases/../CMakeLists.txt" ] || [ ! -x "$cases/../../../bin/twogrid" ] || installed=1
find_program() {
  if [ -n "${TWOGRID:-}" ]; then
    program=$TWOGRID
  elif [ -n "$installed" ]; then
    program=$cases/../../../bin/twogrid
  else
    [ "${1:-}" != --build ] || { "$cases"/setup.sh && "$cases"/build.sh twogrid; } || return 1
    program=$cases/../build/twogrid
  fi
  [ -f "$program" ] && [ -x "$program" ] || {
    echo "there is no program $program: $([ -n "$installed" ] || echo "build it (cases/setup.sh && cases/build.sh), or ")TWOGRID=PROGRAM names one" >&2
    return 1
  }
  program=$(realpath "$program")
}
