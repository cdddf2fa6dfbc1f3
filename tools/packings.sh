#!/usr/bin/env bash
# Runs the decks of inputs/packing, evaluates them, and writes one HTML page with figures, numbers and verdicts.
#
#   tools/packings.sh           the campaign that docs/packings_study.md shows: more than an hour on two cores
#   tools/packings.sh --quick   all of it, short and coarse: a few minutes
#   tools/packings.sh --draw    runs nothing, draws what is there
#   tools/packings.sh --help    all options: -o DIR, -j N, --only NAME, --program FILE, --keep DIR
# Results go to build/packings. It may be stopped at any time: the same command goes on, and the page shows what is
# there, with a list of what is missing. `--keep docs` renews docs/packings_study.md and its figures.
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

PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" exec nice -n 19 "$python" -B -m packings "$@"
