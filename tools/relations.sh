#!/usr/bin/env bash
# Relations that must hold whatever the deck, tried on decks at random over all pairs of features.
#
#   tools/relations.sh                        all relations, 20 decks each
#   tools/relations.sh mirror boost --count 500
#   tools/relations.sh mirror --first 1234 --count 1 --deck     one deck again, which is printed
#   tools/relations.sh --help                 all options; --list says what each relation is
# Exit status 1 when one did not hold. The library is that of build/release. Thousands: tools/soak.sh relations --size full.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

for python in python3 /usr/bin/python3 /usr/local/bin/python3; do
  if "$python" -c 'import h5py, numpy' 2>/dev/null; then
    PYTHONPATH="$root/tools" exec "$python" -m relations "$@"
  fi
done
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
echo "No python3 with h5py and numpy (tools/install_deps.sh --tests)" >&2
exit 2
