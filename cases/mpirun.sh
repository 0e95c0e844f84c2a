#!/bin/sh
# mpirun.sh RANKS COMMAND...: starts a program on so many ranks; on this machine, also as root and with more ranks than cores.
#   $TWOGRID_LAUNCHER  what starts ranks in place of OpenMPI's mpirun, %n for their number: "srun --mpi=pmix -n %n", "mpiexec -n %n"
#   $TWOGRID_GRACE     s that mpirun leaves its ranks after a SIGTERM of its own before it kills them (2). It sleeps twice as long
#                      after every end that is no success, so that more is for batch jobs.
# SIGTERM, SIGINT and SIGUSR1 to this script reach the ranks as SIGUSR1, which every launcher hands on and none takes for its own
# end: twogrid then writes a checkpoint and ends with 138.
set -eu
ranks=$1
shift
export OMP_NUM_THREADS=1  # one core a rank: the mathematics libraries start no threads of their own
if [ -n "${TWOGRID_LAUNCHER:-}" ]; then
  launcher=$(printf %s "$TWOGRID_LAUNCHER" | sed "s/%n/$ranks/g")
else
  # Messages within a node of up to 64 kB are copied at once: the halos of a small bed are larger than the default of 4 kB.
  launcher="mpirun --oversubscribe --bind-to none --mca btl_vader_eager_limit 65536 --mca odls_base_sigkill_timeout ${TWOGRID_GRACE:-2}"
  [ "$(id -u)" -ne 0 ] || launcher="$launcher --allow-run-as-root"
  [ "$ranks" -le "$(nproc)" ] || launcher="$launcher --mca mpi_yield_when_idle 1"
  launcher="$launcher -np $ranks"
fi
# From a terminal Ctrl-C would reach the launcher itself, which kills: it then runs in a session of its own.
alone=
[ ! -t 0 ] || alone=setsid
pid= asked= reminder=
# mpirun loses a signal that comes before its ranks are there: it is told again until it ends. To twogrid the first one counts.
remind() { while sleep 1 && kill -USR1 "$pid"; do :; done; }
tell() {
  kill -USR1 "$pid" 2>/dev/null || true
  [ -n "$reminder" ] || { remind </dev/null >/dev/null 2>&1 & reminder=$!; }
}
# mpirun may hang after a rank that is killed while it starts: it is ended once its ranks are dead for longer than it sleeps.
mourn() {
  alive= dead=0 bound=$((2 * ${TWOGRID_GRACE:-2} + 4))
  while sleep 2 && kill -0 "$pid"; do
    if ps -o stat= --ppid "$pid" | grep -qv '^Z'; then alive=1 dead=0; elif [ -n "$alive" ]; then dead=$((dead + 2)); fi
    [ "$dead" -le "$bound" ] || kill -KILL "$pid"
  done
}
trap 'asked=1; [ -z "$pid" ] || tell' TERM INT USR1
$alone $launcher "$@" &
pid=$!
[ -z "$asked" ] || tell
mourner=
[ -n "${TWOGRID_LAUNCHER:-}" ] || ! command -v ps >/dev/null || { mourn </dev/null >/dev/null 2>&1 & mourner=$!; }
code=0
wait "$pid" || code=$?
# wait also ends at a signal; then the launcher is still there.
while kill -0 "$pid" 2>/dev/null; do
  code=0
  wait "$pid" || code=$?
done
for helper in $reminder $mourner; do kill "$helper" 2>/dev/null || true; done
exit "$code"
