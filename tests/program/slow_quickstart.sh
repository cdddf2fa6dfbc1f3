#!/usr/bin/env bash
# A fresh clone in a bare root of the distribution, where neither compiler nor Python is installed: the quick start, then all
# blocks of README.md on this way, each from a bare shell.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:?}
source=${SLIPDISK_SOURCE_DIR:?}

skip() { echo "skipped: $1"; exit 77; }
[ "$(id -u)" = 0 ] || skip "a bare root is made by root"
command -v mmdebstrap >/dev/null || skip "mmdebstrap is not installed (tools/install_deps.sh --tests)"
# shellcheck disable=SC1091
. /etc/os-release
[ "$ID" = debian ] || skip "the bare root is one of Debian, this is $ID"
mapfile -t sources < <(grep -lE "(^|[[:space:]])$VERSION_CODENAME([[:space:]]|\$)" /etc/apt/sources.list \
  /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources 2>/dev/null)
[ ${#sources[@]} -gt 0 ] || skip "apt has no source of $VERSION_CODENAME"
git -C "$source" rev-parse >/dev/null 2>&1 || skip "$source is not a clone"

work=$build/quickstart
# A run that was killed may have left mounts of /dev and /proc in its root: they are not entered.
rm -rf --one-file-system "$work"
mkdir -p "$work/tmp"
# The tracked files, as the working tree has them
git -C "$source" ls-files -z | (cd "$source" && while IFS= read -r -d '' file; do
  if [ -e "$file" ]; then printf '%s\0' "$file"; fi
done | tar -cf "$work/clone.tar" --null -T -)
cat >"$work/root.sh" <<'END'
set -eu
root=$1 work=$2
mkdir "$root/clone"
tar -xf "$work/clone.tar" -C "$root/clone" --no-same-owner
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 "$@"; }
for word in gcc cmake python3; do ! in_root sh -c "command -v $word" || exit 1; done
in_root sh -c 'cd /clone && tools/quickstart.sh'
in_root sh -c 'cd /clone && python3 tests/docs/test_cookbook.py README --way=quick && cmake --install build/release >/dev/null && cd / && /usr/local/bin/slipdisk version'
echo "bare root: ok"
END
mapfile -t options < <(apt-config dump | sed -n 's/^\(Acquire::Check.*\);$/--aptopt=\1/p')
TMPDIR=$work/tmp mmdebstrap --quiet --variant=minbase --format=null "${options[@]}" --customize-hook="sh '$work/root.sh' \"\$1\" '$work'" \
  "$VERSION_CODENAME" /dev/null "${sources[@]}" >"$work/root.log" 2>&1 || { tail -n 60 "$work/root.log"; exit 1; }
grep -q '^bare root: ok$' "$work/root.log"
sed -n '/^mean rotation/,/^$/p' "$work/root.log"
grep 'README.md:' "$work/root.log"
rm -rf --one-file-system "$work/tmp" "$work/clone.tar"
echo "ok"
