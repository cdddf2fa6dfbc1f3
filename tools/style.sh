#!/usr/bin/env bash
# Formatting and lint of the C sources.
#   tools/style.sh format              rewrites the files after .clang-format
#   tools/style.sh format-check        says which files differ, and fails if any does
#   tools/style.sh lint [BUILD]        clang-tidy with the compile commands of BUILD (build/release), of what has changed
# Version 14 of both tools is preferred: other versions format some lines differently.
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
cd "$(dirname "$0")/.."

tool() {
  local name
  for name in "$1-14" "$1"; do
    if command -v "$name"; then return; fi
  done
  echo "$1 not found (tools/install_deps.sh --tests)" >&2
  return 1
}

sources() { find src include tests -name '*.[ch]' -print0 | sort -z; }

case "${1:-}" in
  format)
    format=$(tool clang-format)
    sources | xargs -0 "$format" -i ;;
  format-check)
    format=$(tool clang-format)
    sources | xargs -0 "$format" --dry-run -Werror
    echo "Formatting: $(sources | tr -cd '\0' | wc -c) files are as .clang-format wants them." ;;
  lint)
    tidy=$(tool clang-tidy)
    build=${2:-build/release}
    if [ ! -f "$build/compile_commands.json" ]; then
      echo "$build/compile_commands.json not found: configure first (cmake --preset release)" >&2
      exit 1
    fi
    python3 tools/lint.py "$build" "$tidy" ;;
  *)
    tools/style.sh --help >&2
    exit 2 ;;
esac
