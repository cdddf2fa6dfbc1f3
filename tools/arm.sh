#!/usr/bin/env bash
# Runs the golden decks (tests/golden.csv) and test_math on another processor: builds them for aarch64 with Debian's cross compiler
# and runs them with qemu-user.
#   tools/arm.sh            builds into build/arm, runs all decks; exit status 1 if a bit differs
#   tools/arm.sh clumps     only these decks
# Needs Debian or Ubuntu, and tools/install_deps.sh --arm. The libraries for arm64 are Debian's packages, fetched once and unpacked
# into build/arm-root; nothing is installed.
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
cd "$(dirname "$0")/.."
root=$PWD/build/arm-root

# Fetches packages for arm64. Lists of packages and state are ours, so that the system stays as it is.
fetch() {
  local own=$root.new/apt
  mkdir -p "$own/lists/partial" "$own/archives/partial"
  : >"$own/status"
  local options=(-q -y -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o "Dir::State::lists=$own/lists"
                 -o "Dir::State::status=$own/status" -o "Dir::Cache::archives=$own/archives" -o Dir::Cache::pkgcache=
                 -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=root -o APT::Install-Recommends=false)
  apt-get "${options[@]}" update >/dev/null
  apt-get "${options[@]}" install --download-only "$@" >/dev/null
  local package
  for package in "$own"/archives/*.deb; do dpkg-deb -x "$package" "$root.new"; done
  rm -r "$own"
}

if [ ! -d "$root" ]; then
  rm -rf "$root.new"
  fetch libgsl-dev libhdf5-dev libconfig-dev libjansson-dev libxxhash-dev zlib1g-dev libcmocka-dev
  mv "$root.new" "$root"
fi
cmake -S . -B build/arm -G Ninja --log-level=WARNING --toolchain tools/cmake/aarch64.cmake -DSLIPDISK_ARM_ROOT="$root" \
  -DCMAKE_BUILD_TYPE=Release -DSLIPDISK_LIVE=OFF >/dev/null
cmake --build build/arm --target slipdisk_program test_math
cat >build/arm/run <<END
#!/bin/sh
exec qemu-aarch64 -L "$root" "$PWD/build/arm/slipdisk" "\$@"
END
chmod +x build/arm/run
qemu-aarch64 -L "$root" build/arm/tests/test_math
PYTHONPATH=tools exec /usr/bin/python3 -m soak.golden build/arm/run "$@"
