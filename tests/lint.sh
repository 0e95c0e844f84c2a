#!/bin/sh
# Reads the code without running it: clang-tidy with the checks of .clang-tidy, and cppcheck. Installs what is missing.
# Words after the command are files to read; all of the program's sources by default. Ends with an error at any finding.
#
# Last run: of all sources 2026-11-29, 1b6d300 and what mended its findings: nothing found, 8.5 min of CPU; of grids from the scene and plan later the same day.
set -eu
cd "$(dirname "$0")/.."
cases/setup.sh clang-tidy cppcheck
[ -f build/compile_commands.json ] || cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release >build.log 2>&1 || { cat build.log >&2; exit 1; }
cores=$(nproc)
[ $# -gt 0 ] || set -- $(find cfd coupling liggghts_fixes -name '*.cpp' | sort)
bad=0

# cppcheck. Left out:
#  uninitvar in the contact kernel: it doesn't know that a vector is filled number by number.
#  invalidPointerCast: halos of float and double share a buffer of bytes.
#  passedByValue: LIGGGHTS' own virtual functions take strings by value.
echo "lint: cppcheck"
cppcheck --quiet --std=c++17 --language=c++ -j "$cores" -I. --error-exitcode=1 --inline-suppr \
  --enable=warning,performance,portability \
  "--suppress=uninitvar:liggghts_fixes/contacts/contact_kernel_*.h" \
  --suppress=invalidPointerCast --suppress=passedByValue:liggghts_fixes/contacts/granular_contacts.cpp \
  "$@" || bad=1

# clang-tidy. Not for files that shuffle vectors by GCC's own built-in function, which it can't read.
echo "lint: clang-tidy"
grep -L -e __builtin_shuffle -e contact_kernel_code "$@" |
  xargs -P "$cores" -n 1 clang-tidy -p build --quiet 2>build/lint.log || bad=1
grep 'error:' build/lint.log >&2 && bad=1
[ $bad -eq 0 ] && echo "lint: nothing found"
exit $bad
