#!/bin/sh
# mpirun.sh RANKS COMMAND...: starts a program on this machine, also as root and with more ranks than cores.
set -eu
ranks=$1
shift
export OMP_NUM_THREADS=1  # one core a rank: the mathematics libraries start no threads of their own
# Messages within a node of up to 64 kB are copied at once: the halos of a small bed are larger than the default of 4 kB.
flags="--oversubscribe --bind-to none --mca btl_vader_eager_limit 65536"
[ "$(id -u)" -ne 0 ] || flags="$flags --allow-run-as-root"
[ "$ranks" -le "$(nproc)" ] || flags="$flags --mca mpi_yield_when_idle 1"
exec mpirun $flags -np "$ranks" "$@"
