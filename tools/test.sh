#!/usr/bin/env bash
# Installs what is missing, builds and runs all tests:
#   1. packages             4. sanitizers (dev preset): build and tests
#   2. formatting           5. clang: build without warnings
#   3. lint                 6. release build with gcc: all tests
#                           7. build with MPI: the tests that start several ranks
# With CI=true also: the tests labelled "long", soak (tools/soak.sh at its small sizes), coverage
# (lines and branches reached, room by room), the tests labelled "slow", which have 25 minutes, and the
# long tests with sanitizers, which the release build tries in any case. Of these last three parts none
# begins when 33 minutes have passed, and soak does not after 50: on slow machines they are left out, which
# is said.
#
#   tools/test.sh           everything
#   tools/test.sh --quick   packages and the release build's tests only
#   tools/test.sh PART...   some parts: packages format lint dev tsan clang release soak coverage mpi slow dev-long play arm
# Part play compiles the engine for browsers and runs its tests; it is in no other list, since emscripten is large. Nor is part
# arm, which runs the golden decks for another processor in an emulator.
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

configure() { cmake --preset "$1" --log-level=WARNING >/dev/null; }

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
    clang)
      say "Build with clang"
      # clang finds the same to warn of whatever it optimises, and nothing of this build is run
      cmake --preset clang --log-level=WARNING -DCMAKE_C_FLAGS_RELEASE=-O0 >/dev/null
      cmake --build --preset clang ;;
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
      build release
      ctest --preset release -R '^test_play' ;;
    arm) say "The golden decks on aarch64"
      tools/install_deps.sh --arm
      tools/arm.sh ;;
    *) tools/test.sh --help >&2; exit 2 ;;
  esac
}

parts=("$@")
if [ $# -eq 0 ]; then
  parts=(packages format lint dev clang release mpi)
  if [ "${CI:-}" = true ]; then parts+=(soak slow coverage dev-long); fi
elif [ "$1" = --quick ]; then
  parts=(packages release)
fi
# Minutes after which a part that takes long is not begun
declare -A latest=([soak]=50 [slow]=33 [coverage]=33 [dev-long]=33)
costs=()
for name in "${parts[@]}"; do
  if [ $# -eq 0 ] && ((SECONDS > 60 * ${latest[$name]:-1000})); then
    costs+=("$name is left out: ${latest[$name]} minutes have passed")
    continue
  fi
  began=$SECONDS before=$(processor)
  part "$name"
  costs+=("$(printf '%-10s %5d s, %5d s of processors' "$name" $((SECONDS - began)) $(($(processor) - before)))")
done
say "All parts"
printf '%s\n' "${costs[@]}"
