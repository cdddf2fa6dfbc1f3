#!/usr/bin/env bash
# The wheel is built from the source archive, holds the libraries with their licences, and does its work where none of these is
# installed: in a bare root of the distribution, and in a fresh environment of each Python from 3.10 on that is on the PATH.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:?}
source=${SLIPDISK_SOURCE_DIR:?}

skip() { echo "skipped: $1"; exit 77; }
python3 -m venv -h >/dev/null 2>&1 || skip "python3 has no venv (tools/install_deps.sh --tests)"
work=$build/wheel
rm -rf "$work"
mkdir -p "$work/tmp"
python3 -m venv "$work/pip"
"$work/pip/bin/pip" download -q -d "$work/tools" scikit-build-core auditwheel 2>"$work/pip.log" ||
  skip "the Python package index is out of reach: $(tail -n 1 "$work/pip.log")"
"$source/tools/packaging/wheel.sh" --no-install --output "$work" >"$work/build.log" 2>&1 || { tail -n 40 "$work/build.log"; exit 1; }
wheel=$(find "$work" -maxdepth 1 -name 'slipdisk-*-manylinux*.whl')
tar -tzf "$work"/slipdisk-*.tar.gz >"$work/source.txt"
grep -q '/src/app/main.c$' "$work/source.txt"
python3 -m zipfile -l "$wheel" >"$work/wheel.txt"
for part in slipdisk.libs/libgsl- slipdisk.libs/libhdf5 licenses/libgsl licenses/libhdf5 licenses/LICENSE slipdisk/py.typed \
  slipdisk/share/slipdisk/inputs/packing/heap.cfg man1/slipdisk-run.1; do
  grep -q "$part" "$work/wheel.txt" || { echo "the wheel lacks $part"; exit 1; }
done
du -h "$wheel" | cut -f 1

# What a user does first. $1: the folder of the environment
cat >"$work/use.sh" <<'END'
set -eu
cd "$(mktemp -d)"
bin=$1/bin
$bin/slipdisk version
inputs=$($bin/python -c 'import slipdisk; print(slipdisk.inputs)')
$bin/slipdisk run "$inputs/three_disk/sync.cfg" -o three.h5 -q -D phases.measure.steps=2e5
$bin/slipdisk info three.h5 >info
grep -q Omega info
$bin/slipdisk view three.h5 -o page.html
test -s page.html -a -f "$1/share/man/man1/slipdisk-run.1"
if $bin/python -c 'import matplotlib' 2>/dev/null; then $bin/slipdisk plot three.h5 -o picture.png; test -s picture.png; fi
$bin/python - "$1" <<'PY'
import sys
import slipdisk
for found in (slipdisk.__file__, slipdisk.library.library()._name, slipdisk.library.program()):
    assert found.startswith(sys.argv[1]), found
simulation = slipdisk.Simulation(slipdisk.inputs / "collisions/two_disks.cfg")
simulation.advance(1000)
assert simulation.step == 1000
result = slipdisk.Result("three.h5")
print("Omega", result.rotation["omega"][0], "Python", sys.version.split()[0], "slipdisk", slipdisk.__version__)
PY
END
tried=0
for minor in 10 11 12 13; do
  python=$(command -v "python3.$minor") || continue
  "$python" -m venv "$work/3.$minor" 2>/dev/null || continue
  "$work/3.$minor/bin/pip" install -q "$wheel[plot]"
  env -i PATH=/usr/bin:/bin HOME="$HOME" sh "$work/use.sh" "$work/3.$minor" | grep '^Omega'
  rm -rf "$work/3.$minor"
  tried=$((tried + 1))
done
[ $tried -gt 0 ] || { echo "no environment was made"; exit 1; }

# In a bare root, with the packages of the index that were fetched here.
# shellcheck disable=SC1091
. /etc/os-release
if [ "$(id -u)" != 0 ] || ! command -v mmdebstrap >/dev/null || [ "$ID" != debian ]; then
  echo "no bare root: it takes root, mmdebstrap and Debian"
  exit 0
fi
mapfile -t sources < <(grep -lE "(^|[[:space:]])$VERSION_CODENAME([[:space:]]|\$)" /etc/apt/sources.list \
  /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources 2>/dev/null)
/usr/bin/python3 -m venv "$work/system"
"$work/system/bin/pip" download -q -d "$work/index" "$wheel" >/dev/null
cat >"$work/root.sh" <<'END'
set -eu
root=$1 work=$2
cp -r "$work/index" "$work/use.sh" "$root/tmp/"
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 "$@"; }
! in_root ldconfig -p | grep -E 'libgsl|libhdf5|libconfig|libjansson' || exit 1
in_root python3 -m venv /opt/slipdisk
in_root /opt/slipdisk/bin/pip install -q --no-index --find-links /tmp/index slipdisk
in_root sh /tmp/use.sh /opt/slipdisk
echo "bare root: ok"
END
mapfile -t options < <(apt-config dump | sed -n 's/^\(Acquire::Check.*\);$/--aptopt=\1/p')
TMPDIR=$work/tmp mmdebstrap --quiet --variant=minbase --include=python3-venv --format=null "${options[@]}" \
  --customize-hook="sh '$work/root.sh' \"\$1\" '$work'" "$VERSION_CODENAME" /dev/null "${sources[@]}" >"$work/root.log" 2>&1 ||
  { tail -n 60 "$work/root.log"; exit 1; }
grep -q '^bare root: ok$' "$work/root.log"
grep '^Omega' "$work/root.log"
rm -rf "$work/tmp" "$work/index" "$work/pip" "$work/system"
echo "ok"
