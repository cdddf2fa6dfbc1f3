#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests.
#
#   tools/test.sh           packages, the release build, and its tests but the longest: about ten minutes on two cores
#   tools/test.sh --all     everything that continuous integration runs (CI=true does the same)
#   tools/test.sh PART...   some parts
#
# Parts of --all, in this order:
#   packages   what is missing is installed       clang     clang and make: lines of docs/install.md
#   format     as .clang-format wants it          release   the release build: all tests
#   lint       clang-tidy, and tools/lint.py      mpi       a build with MPI: the tests that start several ranks
#   dev        address and undefined-behaviour sanitizers: tests but the longest
# Parts that are run by hand: dev-long (the longest tests with sanitizers), slow (tests that take minutes), tsan (thread sanitizer),
# msan (memory sanitizer: tests in C), soak (tools/soak.sh at its small sizes), coverage (lines and branches reached, room by room),
# play (the engine for browsers), arm (the golden decks on aarch64).
#
# Stops at the first part that fails. Run it as often as you like: what ccache and lint have seen goes quickly. The parts
# say at the end how long they took, and how much processor time.
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
cd "$(dirname "$0")/.."

jobs=$(nproc)
# Builds of the same text (release, mpi) share what is compiled.
if command -v ccache >/dev/null; then
  export CMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER:-ccache}
fi

# Those that take longest are left to continuous integration. By presets: beside the label that a preset leaves out, -LE leaves
# out only what has both.
quick=-quick
if [ "${CI:-}" = true ]; then quick=; fi

say() { printf '\n== %s\n' "$*"; }

# Tests may be left out for want of packages only if nothing here has promised them.
promised=tests
configure() {
  cmake --preset "$1" --log-level=WARNING >/dev/null
  if grep -E "^[^ ]+ --($promised)? " "build/$1/tests_left_out.txt" >&2; then
    echo "Packages are missing, and with them the tests that stand behind: tools/install_deps.sh --tests" >&2
    exit 1
  fi
}

build() {
  configure "$1"
  cmake --build --preset "$@"
}

# Processor seconds of all that this script has waited for
processor() { awk -v tick="$(getconf CLK_TCK)" '{ printf "%d", ($16 + $17) / tick }' "/proc/$$/stat"; }

part() {
  case "$1" in
    packages) say "Packages"; tools/install_deps.sh --tests ;;
    format) say "Formatting"; tools/style.sh format-check ;;
    lint)
      say "Lint"
      configure release
      cmake --build --preset lint ;;
    dev) say "Tests with the address and undefined-behaviour sanitizers"
      build dev
      ctest --preset dev-quick -j "$jobs" ;;
    dev-long) say "The longest tests with these sanitizers"
      build dev
      ctest --preset dev-long -j "$jobs" ;;
    tsan) say "Tests with the thread sanitizer"
      build tsan
      ctest --preset "tsan$quick" -j "$jobs" ;;
    msan) say "Tests with the memory sanitizer"
      build msan
      ctest --preset msan -j "$jobs" ;;
    clang)
      say "Build with clang and make, as docs/install.md has it"
      # clang finds the same to warn of whatever it optimises
      rm -rf build/plain build/installed
      CC=clang CMAKE_BUILD_TYPE=None CMAKE_BUILD_PARALLEL_LEVEL=$jobs python3 tests/docs/test_cookbook.py install --way=source ;;
  release) say "Tests of the release build"
      build release
      if [ "$quick" ]; then ctest --preset quick -j "$jobs"; else ctest --preset release -j "$jobs"; fi ;;
    slow) say "Slow tests of the release build"
      build release
      ctest --preset slow -j "$jobs" --stop-time "$(date -d '+25 minutes' +%H:%M:%S)" ;;
    soak) say "Trials that try to lose a result"
      build release
      tools/soak.sh ;;
    coverage) say "Coverage"; tools/soak.sh coverage ;;
    mpi) say "Tests of the build with MPI"
      tools/install_deps.sh --mpi
      build mpi --target slipdisk_program test_comm calls
      ctest --preset "mpi$quick" -L mpi -j "$jobs" ;;
    play) say "The engine in browsers and Node"
      tools/install_deps.sh --tests --play
      tools/play.sh
      promised="tests|play"
      build release
      ctest --preset release -R '^test_play' ;;
    arm) say "The golden decks on aarch64"
      tools/install_deps.sh --arm
      tools/arm.sh ;;
    *) tools/test.sh --help >&2; exit 2 ;;
  esac
}

parts=("$@")
if [ "${1:-}" = --all ] || { [ $# -eq 0 ] && [ "${CI:-}" = true ]; }; then
  quick=
  parts=(packages format lint dev clang release mpi)
elif [ $# -eq 0 ]; then
  parts=(packages release)
fi
costs=()
for name in "${parts[@]}"; do
  began=$SECONDS before=$(processor)
  part "$name"
  costs+=("$(printf '%-10s %5d s, %5d s of processors' "$name" $((SECONDS - began)) $(($(processor) - before)))")
done
say "All parts"
printf '%s\n' "${costs[@]}"
if [ $# -eq 0 ] && [ "$quick" ]; then
  echo "Left out: format, lint, sanitizers, clang, MPI and the $(ctest --preset release -N -L '^long$' | sed -n 's/^Total Tests: //p') \
longest tests (tools/test.sh --all)."
fi
