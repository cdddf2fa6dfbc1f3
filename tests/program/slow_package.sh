#!/usr/bin/env bash
# The .deb is built, lintian finds no error in it, and it does its work in a bare root of the distribution: installed with apt,
# so that what it needs comes along, then used as a user would, then removed.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:?}
source=${SLIPDISK_SOURCE_DIR:?}

skip() { echo "skipped: $1"; exit 77; }
[ "$(id -u)" = 0 ] || skip "a bare root is made by root"
for tool in mmdebstrap lintian dpkg-deb ninja; do
  command -v $tool >/dev/null || skip "$tool is not installed (tools/install_deps.sh --tests)"
done
# shellcheck disable=SC1091
. /etc/os-release
[ "$ID" = debian ] || skip "the bare root is one of Debian, this is $ID"
mapfile -t sources < <(grep -lE "(^|[[:space:]])$VERSION_CODENAME([[:space:]]|\$)" /etc/apt/sources.list \
  /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources 2>/dev/null)
[ ${#sources[@]} -gt 0 ] || skip "apt has no source of $VERSION_CODENAME"

work=$build/package
# A run that was killed may have left mounts of /dev and /proc in its root: they are not entered.
rm -rf --one-file-system "$work"
mkdir -p "$work/tmp"
site=--no-site
if command -v sphinx-build >/dev/null && command -v doxygen >/dev/null; then site=; fi
"$source/tools/packaging/deb.sh" --no-install ${site:+"$site"} --output "$work" >"$work/build.log" 2>&1 ||
  { tail -n 40 "$work/build.log"; exit 1; }
grep '^[EWN]: ' "$work/build.log" || echo "lintian: nothing to say"
deb=$(find "$work" -maxdepth 1 -name '*.deb')
du -h "$deb" | cut -f 1

# As a user without rights, in the bare root.
cat >"$work/use.sh" <<'END'
set -eu
cd "$(mktemp -d)"
slipdisk version
inputs=/usr/share/slipdisk/inputs
slipdisk check $inputs/three_disk/sync.cfg --brief >check
slipdisk run $inputs/three_disk/sync.cfg -o three.h5 -q -D phases.measure.steps=2e5
slipdisk run $inputs/packing/deposit.cfg -o deposit.h5 -q || test $? = 5
slipdisk info three.h5 >info
grep -q Omega info
slipdisk measure deposit.h5 >measure
slipdisk verify three.h5 deposit.h5
slipdisk view three.h5 -o page.html
slipdisk plot three.h5 -o picture.png
test -s page.html -a -s picture.png
slipdisk help --man run | cmp - /tmp/page
test -r /usr/share/bash-completion/completions/slipdisk
test -r /usr/share/doc/slipdisk/copyright
ls /usr/share/doc/slipdisk/html/index.html /usr/share/doc/slipdisk/docs/index.md 2>/dev/null | grep .
python3 - <<'PY'
import slipdisk
assert slipdisk.__file__.startswith("/usr/lib/python3/dist-packages/"), slipdisk.__file__
simulation = slipdisk.Simulation("/usr/share/slipdisk/inputs/collisions/two_disks.cfg")
simulation.advance(1000)
assert simulation.step == 1000
result = slipdisk.Result("three.h5")
print("Omega", result.rotation["omega"][0], "+-", result.rotation["error"][0], "by version", slipdisk.version())
PY
END
cat >"$work/build.sh" <<'END'
set -eu
cd "$(mktemp -d)"
cc /usr/share/slipdisk/inputs/examples/force_field.c $(pkg-config --cflags --libs slipdisk) -lm -o force_field
./force_field >out
test -s out
END
cat >"$work/root.sh" <<'END'
set -eu
root=$1 work=$2
cp "$work"/*.deb "$work/use.sh" "$work/build.sh" "$root/tmp/"
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "$@"; }
# mmdebstrap has apt leave out what is recommended; users do not
in_root sh -c 'apt-get install -q -y -o APT::Install-Recommends=true /tmp/*.deb'
gunzip -c "$root/usr/share/man/man1/slipdisk-run.1.gz" >"$root/tmp/page"
in_root useradd -m user
in_root su - user -c 'sh /tmp/use.sh'
in_root apt-get install -q -y --no-install-recommends gcc libc6-dev pkg-config
in_root su - user -c 'sh /tmp/build.sh'
in_root python3 -c 'import slipdisk'
in_root apt-get remove -q -y slipdisk
! find "$root/usr" "$root/etc" -name '*slipdisk*' ! -path '*/share/man/*' | grep . || exit 1
echo "bare root: ok"
END
mapfile -t options < <(apt-config dump | sed -n 's/^\(Acquire::Check.*\);$/--aptopt=\1/p')
TMPDIR=$work/tmp mmdebstrap --quiet --variant=minbase --format=null "${options[@]}" --customize-hook="sh '$work/root.sh' \"\$1\" '$work'" \
  "$VERSION_CODENAME" /dev/null "${sources[@]}" >"$work/root.log" 2>&1 || { tail -n 60 "$work/root.log"; exit 1; }
grep -q '^bare root: ok$' "$work/root.log"
grep '^Omega' "$work/root.log"
rm -rf --one-file-system "$work/tmp"
echo "ok"
