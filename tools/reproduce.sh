#!/usr/bin/env bash
# Computes the figures of the paper anew and writes one HTML page with figures, numbers and verdicts.
#
#   tools/reproduce.sh           a telling subset at the paper's length: about an hour on two cores
#   tools/reproduce.sh --quick   everything, coarse: about two minutes
#   tools/reproduce.sh --full    the paper's whole campaign: hours
#   tools/reproduce.sh --draw    runs nothing, draws what is there
#   tools/reproduce.sh --help    all options: -o DIR, -j N, --only NAME, --program FILE
# Results go to build/reproduce. It may be stopped at any time: the same command goes on, and the page shows what is
# there, with a list of what is missing. docs/reproduce.md says more.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

# A python3 with h5py, numpy and matplotlib: the first one on the path need not be the system's.
find_python() {
  local candidate
  for candidate in python3 /usr/bin/python3 /usr/local/bin/python3; do
    if "$candidate" -c "import h5py, numpy, matplotlib" 2>/dev/null; then
      echo "$candidate"
      return
    fi
  done
  return 1
}

if ! python=$(find_python); then
  "$root/tools/install_deps.sh" --tests
  python=$(find_python) || { echo "no python3 with h5py, numpy and matplotlib" >&2; exit 2; }
fi

# The program is built unless it is there already or another one is named.
if [ ! -x "$root/build/release/slipdisk" ] && [[ " $* " != *" --program"* && " $* " != *" --help "* ]]; then
  "$root/tools/install_deps.sh"
  cmake -S "$root" -B "$root/build/release" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null
  cmake --build "$root/build/release" --target slipdisk_program
fi

PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -B -m report "$@"
