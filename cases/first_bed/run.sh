#!/bin/sh
# The first bed from a bare checkout to its pictures: installs what is missing, builds, runs on two ranks, compares, draws. Results lie in out/run.
#   run.sh [--short] [-var NAME VALUE ...]      -var: any of the choices at the top of in.first_bed; some 10 s of computing
exec "$(dirname "$0")"/../run first_bed "$@"
