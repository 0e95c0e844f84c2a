#!/bin/sh
# All tests, from a bare checkout: installs what is missing, builds in Release, runs every test. A test that fails shows
# its whole output, with the figures it measured. Words after the command go to ctest, such as -L unit or -R momentum.
set -eu
cd "$(dirname "$0")/.."
cases/setup.sh valgrind  # instruction counts
cases/setup.sh chromium || echo "tests: without chromium the pages of cases/report.py are read by a parser only"
cases/build.sh
cores=$(nproc)
# A test that uses more ranks than there are cores runs alone (ctest's PROCESSORS).
exec ctest --test-dir build --output-on-failure --no-tests=error -j "$cores" "$@"
