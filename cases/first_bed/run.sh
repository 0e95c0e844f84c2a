#!/bin/sh
# The first bed from a bare checkout to its pictures: installs what is missing, builds, runs on two ranks, draws. Results lie in out/run.
# Some 10 s of computing.
exec "$(dirname "$0")"/../run first_bed "$@"
