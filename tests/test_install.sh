#!/usr/bin/env bash
# Installs into an empty folder and builds a program of five lines against what is there, once with
# find_package and once with pkg-config.
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

cat >"$work/main.c" <<'END'
#include "slipdisk/model.h"
int main(void) {
  sd_model *model = sd_model_new();
  sd_model_free(model);
  return model ? 0 : 1;
}
END
cat >"$work/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(consumer LANGUAGES C)
find_package(slipdisk 0.2 REQUIRED)
add_executable(consumer main.c)
target_link_libraries(consumer PRIVATE slipdisk::slipdisk)
END
cmake -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
cmake --build "$work/build" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
"$work/build/consumer"
echo "find_package: ok"

PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name slipdisk.pc)")
library=$(dirname "$PKG_CONFIG_PATH")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046 # words are meant to be split
"${CC:-cc}" "$work/main.c" $(pkg-config --cflags --libs slipdisk) \
  -o "$work/consumer"
LD_LIBRARY_PATH="$library" "$work/consumer"
echo "pkg-config: ok"
