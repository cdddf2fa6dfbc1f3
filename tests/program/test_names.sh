#!/usr/bin/env bash
# What the library exports (default visibility) begins with sd_ and is declared in a public header; all that
# the public headers declare exists. Hidden symbols are named as their room likes, and are
# local in the static library.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:-build/release}
source=${SLIPDISK_SOURCE_DIR:-.}
library=$(find "$build" -maxdepth 1 \( -name 'libslipdisk.a' -o -name 'libslipdisk_inside.a' \) | sort | head -n 1)
[ -n "$library" ] || { echo "no libslipdisk.a in $build" >&2; exit 1; }

exported=$(readelf --wide --symbols "$library" |
  awk '($5 == "GLOBAL" || $5 == "WEAK") && $6 == "DEFAULT" && $7 != "UND" && NF == 8 {print $8}' | sort -u)
[ -n "$exported" ] || { echo "$library: no symbols" >&2; exit 1; }
# SD_API on one line, the name before the first parenthesis, bracket or semicolon.
declared=$(sed -n 's/^\(extern \)\{0,1\}SD_API [^;([]*[ *]\([A-Za-z0-9_]*\)[;([].*/\2/p' "$source"/include/slipdisk/*.h |
  sort -u)

failed=0
report() {
  if [ -n "$2" ]; then
    printf '%s\n%s\n' "$1" "$2" >&2
    failed=1
  fi
}
# A static library whose hidden symbols are local (those of sanitizers and coverage are not).
if [ -f "$build/libslipdisk.a" ] && [ -f "$build/libslipdisk_inside.a" ]; then
  report "Global in libslipdisk.a, but the name does not begin with sd_:" \
    "$(nm --extern-only --defined-only --format=just-symbols "$build/libslipdisk.a" | grep -v -e '^sd_' -e ':$' -e '^$' || true)"
fi
report "Exported, but the name does not begin with sd_:" "$(grep -v '^sd_' <<<"$exported" || true)"
report "Exported, but not declared with SD_API in a public header:" "$(comm -23 <(echo "$exported") <(echo "$declared"))"
report "Declared in a public header, but not in the library:" "$(comm -13 <(echo "$exported") <(echo "$declared"))"
echo "$(wc -l <<<"$exported") exported symbols."
exit $failed
