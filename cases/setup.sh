#!/bin/sh
# Installs what twogrid needs and this machine lacks, with apt. Does nothing, and needs no rights, when all is there.
# Words after the command are further packages.
set -eu

# Where libraries are modules or come from source (cmake --preset cluster) there is nothing to install.
! grep -q '^TWOGRID_OWN_LIBRARIES:[A-Z]*=ON' "$(dirname "$0")/../build/CMakeCache.txt" 2>/dev/null || exit 0
command -v dpkg-query >/dev/null || {
  echo "setup: this is no Debian; cases/batch/clusters.md tells how to build with libraries of your own (cmake --preset cluster)" >&2
  exit 1
}
packages="g++ cmake ninja-build pkg-config git
  libliggghts-dev libpetsc-real-dev openmpi-bin libopenmpi-dev libhdf5-openmpi-dev libeigen3-dev libgtest-dev libbenchmark-dev
  python3 python3-numpy python3-h5py python3-matplotlib $*"

missing=
for p in $packages; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$p" 2>/dev/null || true)" = installed ] || missing="$missing $p"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "setup: missing$missing; install them as root, or install sudo" >&2; exit 1; }
  as_root=sudo
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Runs apt-get; what it says is shown only if it fails.
apt() {
  if ! $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0 "$@" >"$log" 2>&1; then
    return 1
  fi
}
known() { for p in $missing; do apt-cache show "$p" >/dev/null 2>&1 || return 1; done; }
update() { echo "setup: reading the list of packages"; apt update || { cat "$log" >&2; exit 1; }; }

known || update
echo "setup: installing$missing and what they need; this takes a minute or two"
if ! apt install --no-install-recommends $missing; then
  # The list may be older than the archive.
  update
  apt install --no-install-recommends $missing || { cat "$log" >&2; exit 1; }
fi
echo "setup: done"
