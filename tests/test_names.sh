#!/usr/bin/env bash
# Every global symbol of the library begins with sd_, also those that a shared library would hide: in a
# static library they share one name space with the program that links it.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:-build/release}
library=$(find "$build" -maxdepth 1 \( -name 'libslipdisk.a' -o -name 'libslipdisk_inside.a' \) | head -n 1)
[ -n "$library" ] || { echo "no libslipdisk.a in $build" >&2; exit 1; }
names=$(nm --defined-only --extern-only --format=posix "$library" | awk 'NF >= 2 && $0 !~ /:$/ {print $1, $2}')
[ -n "$names" ] || { echo "$library: no symbols" >&2; exit 1; }
wrong=$(echo "$names" | grep -v '^sd_' || true)
if [ -n "$wrong" ]; then
  echo "Global symbols of $library that do not begin with sd_ (make them static or rename them):" >&2
  echo "$wrong" >&2
  exit 1
fi

# What a shared library shows is what the public headers declare.
headers=$(cat "${SLIPDISK_SOURCE_DIR:-.}"/include/slipdisk/*.h)
visible=$(readelf --wide --symbols "$library" |
  awk '$5 == "GLOBAL" && $6 == "DEFAULT" && $7 != "UND" && ($4 == "FUNC" || $4 == "OBJECT") {print $8}' | sort -u)
for name in $visible; do
  if ! grep -qw "$name" <<<"$headers"; then
    echo "$name is exported but in no public header" >&2
    exit 1
  fi
done
echo "$(echo "$names" | wc -l) global symbols, $(echo "$visible" | wc -l) of them exported."
