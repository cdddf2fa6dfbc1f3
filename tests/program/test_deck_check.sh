#!/usr/bin/env bash
# test_deck_check.sh: `slipdisk check` on the decks that ship, on decks with mistakes, and on its own output.
set -euo pipefail
source_dir=${SLIPDISK_SOURCE_DIR:-$(cd "$(dirname "$0")/../.." && pwd)}
program=${SLIPDISK_PROGRAM:-$source_dir/build/release/slipdisk}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# status WANTED COMMAND...: the exit status must be WANTED; output in $work/out and $work/err
status() {
  local wanted=$1 got=0
  shift
  "$@" >"$work/out" 2>"$work/err" || got=$?
  [[ $got == "$wanted" ]] || { cat "$work/err" >&2; fail "status $got, expected $wanted: $*"; }
}

for deck in "$source_dir"/inputs/*/*.cfg; do
  [[ $deck != */cookbook/* ]] || continue # test_cookbook runs these, with the files that they read
  # a deck that begins with what another one makes is refused until that is there
  if made=$(grep -v '^#' "$deck" | grep -o 'file = "\(deposit\|cage_start\)[^"]*"'); then
    status 2 "$program" check "$deck" --brief
    grep -q "$made" "$work/err" || fail "no word about $made in $deck"
    other=${made#*\"}
    grep -q "; .slipdisk run .*/${other%.h5\"}.cfg -o .*/${other%\"}. makes it" "$work/err" || fail "not told how to make $made"
    continue
  fi
  status 0 "$program" check "$deck" --brief
  # decks that ask how long a step may be have steps that are too long
  if [[ $deck == */error_*.cfg ]]; then
    grep -v '^warning: dt = ' "$work/err" >"$work/other" || true
    mv "$work/other" "$work/err"
  fi
  [[ ! -s $work/err ]] || { cat "$work/err" >&2; fail "messages about $deck"; }
  grep -q '^# run time ' "$work/out" || fail "no run time for $deck"
done

# the output is a deck, and says the same when it is checked
status 0 "$program" check "$source_dir/inputs/three_disk/async.cfg" --no-probe -D 'gravity.tilt=0.02 pi'
cp "$work/out" "$work/full.cfg"
grep -q 'tilt = "0.02 pi"' "$work/full.cfg" || fail "-D has no effect"
status 0 "$program" check "$work/full.cfg" --no-probe
diff <(sed 's/  # default//; /^# deck /d' "$work/full.cfg") <(sed 's/  # default//; /^# deck /d' "$work/out") ||
  fail "the full deck is not read as it was written"

status 2 "$program" check "$source_dir/tests/decks/many.cfg"
[[ $(wc -l <"$work/err") == $(wc -l <"$source_dir/tests/decks/many.expected") ]] || fail "not every mistake is reported"
status 2 "$program" check "$source_dir/inputs/epo/symmetric.cfg" -D gravty.g=1
grep -q 'did you mean "gravity"' "$work/err" || fail "no suggestion"
status 2 "$program" check "$source_dir/inputs/epo/symmetric.cfg" -D phases.0.steps=1
grep -q 'did you mean phases\[0\]' "$work/err" || fail "no hint to [ ]"
status 2 "$program" check
status 2 "$program" check "$work/nothing.cfg"

# dt against the shortest period is a warning, beyond the limit of stability an error
status 0 "$program" check "$source_dir/inputs/epo/symmetric.cfg" --no-probe --brief -D dt=1.5e-4
grep -q '^warning: dt = 0.00015 ' "$work/err" || fail "no warning about dt"
status 2 "$program" check "$source_dir/inputs/epo/symmetric.cfg" --no-probe --brief -D dt=2e-4
grep -q 'dt = 0.0002: beyond 0.000179' "$work/err" || fail "no error about dt"
status 0 "$program" check --keys
echo "ok"
