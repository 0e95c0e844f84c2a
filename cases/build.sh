#!/bin/sh
# Builds in Release under build/. Words after the command are what to build: all by default, or for example twogrid.
set -eu
cd "$(dirname "$0")/.."
if [ ! -f build/build.ninja ]; then
  echo "build: configuring"
  cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release >build.log 2>&1 || { cat build.log >&2; exit 1; }
fi
exec ninja -C build "$@"
