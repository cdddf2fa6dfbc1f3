#!/usr/bin/env bash
# Builds the engine for browsers and Node: build/play/slipdisk.wasm, the module slipdisk.mjs around it, and the pages, each
# one file that needs nothing else.
#   tools/play.sh            needs emscripten (tools/install_deps.sh --play)
# GSL and libconfig are compiled from Debian's source packages, which are fetched once into build/play-sources. Elsewhere, or
# without a network, SLIPDISK_GSL_SOURCE and SLIPDISK_LIBCONFIG_SOURCE name folders with their sources.
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
cd "$(dirname "$0")/.."

if ! command -v emcc >/dev/null; then
  echo "emcc not found: tools/install_deps.sh --play" >&2
  exit 1
fi
sources=$PWD/build/play-sources

# Fetches the source package $1 and unpacks it into a folder of that name. The package lists are ours: those of the system
# seldom have sources.
fetch() {
  local own=$sources/apt file
  if [ -d "$sources/$1" ]; then return; fi
  if [ ! -d "$own/lists/partial" ]; then
    mkdir -p "$own/lists/partial" "$own/parts"
    touch "$own/sources.list"
    if [ -f /etc/apt/sources.list ]; then sed -n 's/^deb /deb-src /p' /etc/apt/sources.list >"$own/sources.list"; fi
    for file in /etc/apt/sources.list.d/*.sources; do
      if [ -f "$file" ]; then sed 's/^Types:.*/Types: deb-src/' "$file" >"$own/parts/${file##*/}"; fi
    done
  fi
  local options=(-q -o "Dir::State::lists=$own/lists" -o "Dir::Etc::sourcelist=$own/sources.list"
                 -o "Dir::Etc::sourceparts=$own/parts" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache=
                 -o APT::Sandbox::User=root)
  apt-get "${options[@]}" update >/dev/null
  (cd "$own" && apt-get "${options[@]}" source --download-only "$1" >/dev/null)
  mkdir -p "$sources/$1.new"
  tar xf "$own/$1"_*.orig.tar.gz -C "$sources/$1.new" --strip-components=1
  mv "$sources/$1.new" "$sources/$1"
}

if [ -z "${SLIPDISK_GSL_SOURCE:-}" ]; then fetch gsl; fi
if [ -z "${SLIPDISK_LIBCONFIG_SOURCE:-}" ]; then fetch libconfig; fi
emcmake cmake -S tools/play -B build/play-wasm -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING \
  -DSLIPDISK_GSL_SOURCE="${SLIPDISK_GSL_SOURCE:-$sources/gsl}" \
  -DSLIPDISK_LIBCONFIG_SOURCE="${SLIPDISK_LIBCONFIG_SOURCE:-$sources/libconfig}" >/dev/null 2>&1
cmake --build build/play-wasm
mkdir -p build/play
cp build/play-wasm/slipdisk.wasm tools/play/slipdisk.mjs tools/play/slipdisk.d.mts build/play/
python3 tools/play/bundle.py build/play
ls -l build/play | awk 'NR > 1 { printf "%9d bytes  build/play/%s\n", $5, $NF }'
