#!/usr/bin/env bash
# Builds slipdisk_VERSION_ARCHITECTURE.deb: program, C library, Python package, documentation, decks.
#   tools/packaging/deb.sh                 installs what is missing, builds the site and the package, checks it with lintian
#   tools/packaging/deb.sh --no-install    without installing anything
#   tools/packaging/deb.sh --no-site       with docs/*.md and not with the site
#   tools/packaging/deb.sh --output DIR    puts the package into DIR (build)
set -euo pipefail
usage() { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; }
install=yes site=build/site output=build
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --no-install) install=no ;;
    --no-site) site=none ;;
    --output) shift; output=$(realpath -m -- "${1:?--output needs a folder}") ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
cd "$(dirname "$0")/../.."
if [ $install = yes ]; then tools/install_deps.sh --docs --deb; fi

cmake -S . -B build/deb -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr -DBUILD_SHARED_LIBS=ON \
  -DCMAKE_INSTALL_LIBDIR="lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)" -DSLIPDISK_TESTS=OFF -DCMAKE_INSTALL_RPATH_USE_LINK_PATH=OFF \
  -DSLIPDISK_SITE="$PWD/$site" -DCMAKE_PROJECT_INCLUDE="$PWD/tools/packaging/reproducible.cmake" >/dev/null
cmake --build build/deb
# The site asks the program for the names of results.
if [ $site != none ]; then SLIPDISK_PROGRAM=$PWD/build/deb/slipdisk tools/docs.sh --no-install; fi
SOURCE_DATE_EPOCH=$(date -u -d "$(sed -n 's/.*SD_VERSION_DATE "\(.*\)".*/\1/p' include/slipdisk/version.h)" +%s)
export SOURCE_DATE_EPOCH
rm -rf build/deb/packages; mkdir -p "$output"
cpack --config build/deb/CPackConfig.cmake -B build/deb/packages
deb=$(find build/deb/packages -maxdepth 1 -name "*.deb")
mv "$deb" "$output/"
deb=$output/$(basename "$deb")
if command -v lintian >/dev/null; then lintian --fail-on error --allow-root "$deb"; fi
echo "package $deb"
