#!/usr/bin/env bash
# A fresh clone: all blocks of README.md on the way of pip, each from a bare shell with a new home; then the command, with the
# PYTHONPATH of the other way. The same of docs/install.md, by pip and into a folder of one's own.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:?}
source=${SLIPDISK_SOURCE_DIR:?}

skip() { echo "skipped: $1"; exit 77; }
/usr/bin/python3 -m venv -h >/dev/null 2>&1 || skip "python3 has no venv (tools/install_deps.sh --pip)"
git -C "$source" rev-parse >/dev/null 2>&1 || skip "$source is not a clone"
work=$build/readme
rm -rf "$work"
mkdir -p "$work/home" "$work/clone"
/usr/bin/python3 -m venv "$work/try"
"$work/try/bin/pip" download -q -d "$work/tools" scikit-build-core matplotlib 2>"$work/pip.log" ||
  skip "the Python package index is out of reach: $(tail -n 1 "$work/pip.log")"
# The tracked files, as the working tree has them
git -C "$source" ls-files -z | (cd "$source" && while IFS= read -r -d '' file; do
  if [ -e "$file" ]; then printf '%s\0' "$file"; fi
done | tar -c --null -T - | tar -x -C "$work/clone")
cd "$work/clone"
unset SLIPDISK_SOURCE_DIR SLIPDISK_BUILD_DIR SLIPDISK_PROGRAM SLIPDISK_PYTHON SLIPDISK_LIBRARY PYTHONPATH
HOME=$work/home /usr/bin/python3 tests/docs/test_cookbook.py README --way=pip
cd results
bare() { env -i PATH=/usr/bin:/bin HOME="$work/home" PYTHONPATH="$work/clone/tools/python" "$@"; }
bare "$work/home/slipdisk/bin/slipdisk" version
bare "$work/home/slipdisk/bin/slipdisk" plot heap.h5 -o again.png
test -s again.png
cd ..
for way in pip own; do
  mkdir "$work/$way"
  HOME=$work/$way /usr/bin/python3 tests/docs/test_cookbook.py install --way=$way
done
rm -rf "$work"
echo "ok"
