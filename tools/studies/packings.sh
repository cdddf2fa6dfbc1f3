#!/usr/bin/env bash
# Runs the decks of inputs/packing, evaluates them, and writes one HTML page with figures, numbers
# and verdicts.
#
#   tools/studies/packings.sh           the campaign of docs/studies/packings_study.md: about
#                                       three hours of one core
#   tools/studies/packings.sh --quick   all of it, short and coarse: a few minutes
#   tools/studies/packings.sh --large   besides, 100000 disks: 25 minutes more of one core
#   tools/studies/packings.sh --draw    runs nothing, draws what is there; without results from
#                                       docs/studies/data alone
#   tools/studies/packings.sh --help    all options: -o DIR, -j N, --only NAME, --program FILE,
#                                       --keep DIR
# Results go to build/packings. It may be stopped at any time: the same command goes on, and the
# page shows what is there, with a list of what is missing. `--keep docs/studies` renews
# docs/studies/packings_study.md and its figures.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)

. "$root/tools/prepare.sh"
PYTHONPATH="$root/tools/studies${PYTHONPATH:+:$PYTHONPATH}" exec nice -n 19 "$python" -B -m packings "$@"
