#!/usr/bin/env bash
# Tries to make slipdisk lose or falsify a result, and counts what happened.
#
#   tools/soak.sh                     all modes at small sizes (a quarter of an hour on two cores)
#   tools/soak.sh --size full         all modes at the sizes of docs/reliability.md (hours)
#   tools/soak.sh kill faults         only these modes; --list names them all
#   tools/soak.sh --help              all options: --size, --seed, -o DIR, --program FILE, --keep DIR
# Prints a row per kind of trial: how many were made, how many failed. Exit status 1 when any failed.
# The program is build/release/slipdisk; it is built when it is missing.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

python=
for candidate in python3 /usr/bin/python3 /usr/local/bin/python3; do
  if "$candidate" -c 'import h5py, numpy' 2>/dev/null; then python=$candidate && break; fi
done
if [ -z "$python" ]; then
  case " $* " in
    *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
  esac
  echo "No python3 with h5py and numpy (tools/install_deps.sh --tests)" >&2
  exit 2
fi
PYTHONPATH="$root/tools" exec "$python" -m soak "$@"
