#!/bin/sh
# Builds in Release under build/. Words after the command are what to build: all by default, or for example twogrid. A build/ that
# cmake --preset has set up keeps its choices.
set -eu
cd "$(dirname "$0")/.."
if [ ! -f build/CMakeCache.txt ]; then
  [ -w . ] || { echo "build: $(pwd) may not be written: cmake -S '$(pwd)' -B FOLDER && cmake --build FOLDER, then TWOGRID=FOLDER/twogrid for the scripts" >&2; exit 1; }
  echo "build: configuring"
  cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release >build.log 2>&1 || { rm -f build/CMakeCache.txt; cat build.log >&2; exit 1; }
fi
exec cmake --build build --parallel "$(($(nproc) + 2))" ${*:+--target} "$@"
