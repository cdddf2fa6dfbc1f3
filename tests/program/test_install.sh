#!/usr/bin/env bash
# Installs into an empty folder and builds the first program of docs/library.md against what is there, once with
# find_package and once with pkg-config; and imports the Python package.
set -euo pipefail
build=${SLIPDISK_BUILD_DIR:?}
source=${SLIPDISK_SOURCE_DIR:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >/dev/null
test -f "$work/prefix/include/slipdisk/model.h"
if [ -x "$build/slipdisk" ]; then test -x "$work/prefix/bin/slipdisk"; fi
# All headers, and each of them on its own.
for header in "$source"/include/slipdisk/*.h; do
  name=$(basename "$header")
  test -f "$work/prefix/include/slipdisk/$name"
  echo "#include \"slipdisk/$name\"" | "${CC:-cc}" -std=c11 -fsyntax-only -Wall -Wextra -Werror \
    -I"$work/prefix/include" -x c -
done

# All of them in a program in C++, where there is a compiler for it.
if echo "int main() {}" | "${CC:-cc}" -x c++ -fsyntax-only - 2>/dev/null; then
  echo '#include "slipdisk/slipdisk.h"
int main() { sd_disk disk = {}; return disk.radius == 0 && SD_VERSION_NUMBER >= 300 ? 0 : 1; }' |
    "${CC:-cc}" -x c++ -fsyntax-only -Wall -Wextra -Werror -I"$work/prefix/include" -
fi

# The first program of docs/library.md, and what it prints there.
sed -n '/^```c$/,/^```$/p' "$source/docs/library.md" | grep -v '^```' >"$work/main.c"
printed=$(sed -n 's/^It prints `\([^`]*\)`.*/\1/p' "$source/docs/library.md")
test -n "$printed"
cat >"$work/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(consumer LANGUAGES C)
find_package(slipdisk 0.6 REQUIRED)
add_executable(consumer main.c)
target_link_libraries(consumer PRIVATE slipdisk::slipdisk)
END
cmake -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/build" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
test "$("$work/build/consumer")" = "$printed"
echo "find_package: ok"

PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name slipdisk.pc)")
library=$(dirname "$PKG_CONFIG_PATH")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046 # words are meant to be split
"${CC:-cc}" "$work/main.c" $(pkg-config --cflags --libs slipdisk) \
  -o "$work/consumer"
test "$(LD_LIBRARY_PATH="$library" "$work/consumer")" = "$printed"
echo "pkg-config: ok"

# The line of docs/library.md for a clone, which installs nothing.
line=$(grep -- '-Wl,-rpath' "$source/docs/library.md")
if [ -e "$build/libslipdisk.so" ]; then
  cp -r "$source/include" "$work/include"
  mkdir -p "$work/build" && ln -s "$build" "$work/build/release"
  (cd "$work" && cp main.c first.c && bash -c "$line" && test "$(./first)" = "$printed")
  echo "clone: ok"
fi

# The Python package finds the library and the program of its own prefix.
package="$work/prefix/lib/python3/dist-packages"
if [ -n "${SLIPDISK_PYTHON:-}" ]; then
  (cd "$work" && env -u SLIPDISK_LIBRARY -u SLIPDISK_PROGRAM PYTHONPATH="$package" PYTHONDONTWRITEBYTECODE=1 \
    "$SLIPDISK_PYTHON" - "$work/prefix" <<'END'
import sys
import slipdisk
simulation = slipdisk.Simulation(sys.argv[1] + "/share/slipdisk/inputs/collisions/two_disks.cfg")
simulation.advance(10)
assert simulation.step == 10
for found in (slipdisk.__file__, slipdisk.library.library()._name, slipdisk.library.program()):
    assert found.startswith(sys.argv[1]), found
END
  )
  echo "python: ok"
fi
