#!/bin/sh
# The address and undefined-behaviour sanitizers: builds in build-sanitize/ (preset sanitize), runs the unit tests on one
# and two ranks and six short system tests. Any report of a sanitizer fails its test. Words after the command go to ctest.
#
# Left out: leaks (OpenMPI, PETSc and LIGGGHTS keep what they allocate until the end of the process).
#
# Last run: none has gone through yet (the build alone takes a quarter of an hour on two busy cores).
set -eu
cd "$(dirname "$0")/.."
cases/setup.sh
[ -f build-sanitize/build.ninja ] || cmake --preset sanitize >build.log 2>&1 || { cat build.log >&2; exit 1; }
ninja -C build-sanitize unit_tests twogrid
export ASAN_OPTIONS="detect_leaks=0:abort_on_error=0:exitcode=99:${ASAN_OPTIONS:-}"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1:${UBSAN_OPTIONS:-}"
tests='^unit/.*_np[12]$|^(scripts|fixed_particles|action_reaction|come_and_go|watched_drag|restart)$'
exec ctest --test-dir build-sanitize --output-on-failure --no-tests=error -j "$(nproc)" -R "$tests" "$@"
