#!/usr/bin/env bash
# Builds slipdisk_VERSION_ARCHITECTURE.deb: program, C library, Python package, documentation, decks.
#   tools/packaging/deb.sh                 installs what is missing, builds the site and the package, checks it with lintian
#   tools/packaging/deb.sh --no-install    without installing anything; without Sphinx the package holds docs/*.md
#   tools/packaging/deb.sh --output DIR    puts the package into DIR (build)
set -euo pipefail
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }
install=yes output=build
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
if [ $install = yes ]; then tools/install_deps.sh --docs --deb; fi

if [ -x tools/docs.sh ] && command -v sphinx-build doxygen >/dev/null; then
  tools/docs.sh --no-install
fi
cmake -S . -B build/deb -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr -DCMAKE_INSTALL_LIBDIR="lib/$(
  dpkg-architecture -qDEB_HOST_MULTIARCH)" -DBUILD_SHARED_LIBS=ON -DSLIPDISK_TESTS=OFF >/dev/null
cmake --build build/deb
SOURCE_DATE_EPOCH=$(date -u -d "$(sed -n 's/.*SD_VERSION_DATE "\(.*\)".*/\1/p' include/slipdisk/version.h)" +%s)
export SOURCE_DATE_EPOCH
rm -rf build/deb/packages; mkdir -p "$output"
cpack --config build/deb/CPackConfig.cmake -B build/deb/packages
deb=$(find build/deb/packages -maxdepth 1 -name "*.deb")
mv "$deb" "$output/"
deb=$output/$(basename "$deb")
if command -v lintian >/dev/null; then lintian --fail-on error --allow-root "$deb"; fi
echo "package $deb"
