#!/usr/bin/env bash
# From a fresh clone to a first result: installs what is missing, builds, runs three disks driven by
# random vibration for 10 to 20 seconds, and prints the mean rotation velocity with its error bar.
# Run it as often as you like: the result is made anew each time.
#   tools/quickstart.sh                all of it, also what plots, films and Python need
#   tools/quickstart.sh --no-install   without the packages
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
case "$*" in
  "" | --no-install) ;;
  *) "$0" --help >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."

echo "== 1/3 Packages"
if [ $# -eq 0 ]; then tools/install_deps.sh --plot; else echo "left as they are"; fi

echo "== 2/3 Build (Release) into build/release"
cmake --preset release --log-level=WARNING >/dev/null
cmake --build build/release --target slipdisk_program libslipdisk.a slipdisk_shared manual   # all that is installed

deck=inputs/three_disk/random.cfg
result=results/quickstart/three_disk_random.h5
echo "== 3/3 Run: $deck"
mkdir -p "$(dirname "$result")"
# Four times the deck's own length, 10 to 20 s: then the mean stands clear of its error bar.
build/release/slipdisk run "$deck" -o "$result" --force -D phases.measure.steps=8e7

echo
echo "== Done: the upper disk turns on average, although its supports only vibrate"
build/release/slipdisk info "$result" | sed -n '/^mean rotation/,/^$/p'
echo "result  $result"
echo "more    build/release/slipdisk info $result; README.md, \"Five minutes\", whose commands all work now"
