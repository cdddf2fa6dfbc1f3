#!/usr/bin/env bash
# The program is linked so that an address is hard to guess and the loader's tables cannot be written, no memory is both written
# and run, and functions with arrays look at their stack before they return; the kernels do not.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:-build/release}
program=${SLIPDISK_PROGRAM:-$build/slipdisk}
failed=0
expect() { # what, whether it is so
  if [ "$2" != yes ]; then
    echo "$program: expected $1" >&2
    failed=1
  fi
}
holds() { grep -q "$1" && echo yes || echo no; }

headers=$(readelf --wide --file-header --program-headers "$program")
dynamic=$(readelf --wide --dynamic "$program")
symbols=$(readelf --wide --dyn-syms "$program")
expect "a position-independent executable" "$(holds 'FLAGS_1.*PIE' <<<"$dynamic")"
expect "all symbols bound at the start (BIND_NOW)" "$(holds 'FLAGS_1.*NOW' <<<"$dynamic")"
expect "tables that become read-only (GNU_RELRO)" "$(holds GNU_RELRO <<<"$headers")"
expect "a stack that cannot be run" "$(grep GNU_STACK <<<"$headers" | holds ' RW ')"
expect "a stack protector" "$(holds __stack_chk_fail <<<"$symbols")"
expect "checked string functions (_FORTIFY_SOURCE)" "$(holds '__[a-z]*printf_chk' <<<"$symbols")"

# A distribution's compiler may protect all it compiles: then the kernels are as it likes.
if ! "${CC:-cc}" -Q --help=common 2>/dev/null | grep -q 'fstack-protector-strong.*enabled'; then
  while read -r object; do
    if readelf --wide --symbols "$object" | grep -q __stack_chk_fail; then
      echo "$object: a kernel with a stack protector" >&2
      failed=1
    fi
  done < <(find "$build"/CMakeFiles/slipdisk_kernel_*.dir -name '*.o')
fi
exit $failed
