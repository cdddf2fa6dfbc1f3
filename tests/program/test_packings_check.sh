#!/usr/bin/env bash
# test_packings_check.sh: `slipdisk check` on a deck with each container and each generator, and on its own output.
set -euo pipefail
source_dir=${SLIPDISK_SOURCE_DIR:-$(cd "$(dirname "$0")/../.." && pwd)}
program=${SLIPDISK_PROGRAM:-$source_dir/build/release/slipdisk}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

containers=(
  'type = "box"; width = 10; height = 8;'
  'type = "box"; width = 10; height = 8; open = false;'
  'type = "channel"; width = 10; height = 8;'
  'type = "bed"; width = 10; height = 8; radius = 0.3;'
  'type = "hopper"; width = 10; height = 8; outlet = 2; angle = "45 deg";'
  'type = "drum"; radius = 5; origin = (0, 5);'
  'type = "periodic"; width = 10; height = 8; origin = (-5, 0);'
)
generators=(
  'type = "triangular"; jitter = 1; spacing = 0.6;'
  'type = "square"; count = 30;'
  'type = "random"; fraction = 0.3;'
  'type = "front"; x = (-2, 2); y = (2, 6);'
  'type = "rain"; count = 40; x = (-2, 2); y = (2, 6);'
)
for container in "${containers[@]}"; do
  for generator in "${generators[@]}"; do
    [[ $container == *periodic* && $generator == *rain* ]] && continue
    gravity="gravity = { g = 9.81; };"
    [[ $container == *periodic* ]] && gravity="" # nothing would hold the disks
    cat >"$work/deck.cfg" <<EOF
dt = 1e-4; steps = 10; $gravity
materials = ( { name = "m"; k_n = 1e4; gamma_n = 1; } );
container = { $container };
packings = ( { $generator sizes = "gaussian"; radius = 0.25; deviation = 0.01; density = 1; } );
EOF
    "$program" check "$work/deck.cfg" --no-probe >"$work/one" 2>"$work/err" ||
      { cat "$work/err" >&2; fail "$container $generator"; }
    [[ ! -s $work/err ]] || { cat "$work/err" >&2; fail "messages about $container $generator"; }
    "$program" check "$work/one" --no-probe >"$work/two" || fail "the full deck is refused: $container $generator"
    # the texts of the decks have other lengths, and the result holds them
    plain='s/  # default//; /^# deck /d; s/about [0-9.]* [kMG]B//'
    diff <(sed "$plain" "$work/one") <(sed "$plain" "$work/two") ||
      fail "the full deck is not read as it was written: $container $generator"
  done
done

# what cannot fit ends with status 2 and one line
sed -i 's/^packings.*/packings = ( { type = "random"; count = 100000; radius = 0.25; density = 1; } );/' "$work/deck.cfg"
status=0
"$program" check "$work/deck.cfg" --no-probe >"$work/out" 2>"$work/err" || status=$?
[[ $status == 2 && $(wc -l <"$work/err") == 1 ]] || fail "100000 disks fit"
echo "ok"
