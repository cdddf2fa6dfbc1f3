#!/usr/bin/env bash
# The program is linked so that an address is hard to guess and the loader's tables cannot be written, no memory is both written
# and run, and functions with arrays look at their stack before they return; the kernels do not. No file that was built or
# installed looks for libraries in the current folder.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:-build/release}
program=$(realpath "${SLIPDISK_PROGRAM:-$build/slipdisk}")
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

# RUNPATH: folders by their absolute path, or beside the file ($ORIGIN). An empty element is the current folder.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/installed" >"$work/install.log"
looked=0
while read -r -d '' file; do
  [ "$(head -c 4 "$file" | tr -d '\0')" = $'\x7fELF' ] || continue
  looked=$((looked + 1))
  while read -r path; do
    while read -r -d : folder; do
      case $folder in
        /* | '$ORIGIN' | '$ORIGIN/'*) ;;
        *) echo "$file: RUNPATH \"$path\": expected absolute folders, not \"$folder\"" >&2; failed=1 ;;
      esac
    done <<<"$path:"
  done < <(readelf --wide --dynamic "$file" | sed -nE 's/.*\((RUNPATH|RPATH)\).*\[(.*)\]$/\2/p')
done < <(find "$build" "$work/installed" -type f \( -perm -u+x -o -name '*.so*' \) -not -path '*/CMakeFiles/*' -print0)
[ $looked -ge 5 ] || { echo "only $looked programs and libraries were looked at" >&2; failed=1; }

# A library of a name that the program loads lies where the user stands: it is left there.
mkdir "$work/here"
echo '__attribute__((constructor)) static void run(void) { __builtin_trap(); }' >"$work/trap.c"
"${CC:-cc}" -shared -fPIC -o "$work/trap.so" "$work/trap.c"
while read -r name; do cp "$work/trap.so" "$work/here/$name"; done < <(sed -nE 's/.*\(NEEDED\).*\[(.*)\]$/\1/p' <<<"$dynamic")
for one in "$program" "$work/installed/bin/slipdisk"; do
  (cd "$work/here" && "$one" --version >/dev/null) || { echo "$one runs a library of the current folder" >&2; failed=1; }
done

# Nor does `plot` take a module of Python from there.
for name in sys importlib runpy numpy h5py matplotlib slipdisk; do echo 'open("ran", "w")' >"$work/here/$name.py"; done
for command in plot film; do
  (cd "$work/here" && "$program" $command none.h5 >"$work/told" 2>&1) || true
  if [ -e "$work/here/ran" ]; then echo "slipdisk $command runs a module of the current folder" >&2; failed=1; fi
done
grep -q 'none.h5' "$work/told" || { cat "$work/told" >&2; failed=1; }
exit $failed
