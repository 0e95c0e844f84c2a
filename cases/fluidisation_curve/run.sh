#!/bin/sh
# Sets up, builds, ramps the gas through minimum fluidisation and back, compares and draws. Options (-var Umax 0.4 ...)
# go to the script. About half a minute of computing.
exec "$(dirname "$0")"/../run fluidisation_curve "$@"
