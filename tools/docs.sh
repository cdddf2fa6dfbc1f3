#!/usr/bin/env bash
# Builds the documentation site: pages of docs/, the C interface from the headers, the Python interface from its docstrings.
# It needs no network and no server: open build/site/index.html. A broken link or reference is an error. Names of results are asked of
# the program, build/release/slipdisk or SLIPDISK_PROGRAM; without one their page has no lists.
#   tools/docs.sh                 installs what is missing, builds into build/site
#   tools/docs.sh --no-install    without the packages
#   tools/docs.sh --output DIR    builds into DIR
#   tools/docs.sh --gallery       makes the pictures of docs/gallery.md anew before (minutes; build/release/slipdisk, results/gallery)
set -euo pipefail
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }
install=yes output= gallery=no
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --no-install) install=no ;;
    --gallery) gallery=yes ;;
    --output) shift; output=$(realpath -m -- "${1:?--output needs a folder}") ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
cd "$(dirname "$0")/.."
output=${output:-$PWD/build/site}
work=$output.work # doxygen's XML and Sphinx's own files
if [ $install = yes ]; then tools/install_deps.sh --docs; fi
for tool in doxygen sphinx-build; do
  command -v $tool >/dev/null || { echo "$tool is missing: tools/install_deps.sh --docs" >&2; exit 1; }
done

if [ $gallery = yes ]; then tools/docs/gallery.py build/release/slipdisk; fi
# Anew each time: Sphinx does not see changes of conf.py and of headers, and keeps pages that are gone.
if [ -f "$output/.buildinfo" ]; then rm -r "$output"; fi
mkdir -p "$work/doxygen"
SLIPDISK_SOURCE=$PWD SLIPDISK_OUTPUT=$work/doxygen doxygen tools/docs/Doxyfile
SLIPDISK_DOXYGEN_XML=$work/doxygen/xml PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 -m sphinx -E -W --keep-going -n -q \
  -d "$work/doctrees" docs "$output"
echo "site    $output/index.html"
