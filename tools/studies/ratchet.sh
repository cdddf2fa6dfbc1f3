#!/usr/bin/env bash
# Computes the figures of the paper anew and writes one HTML page with figures, numbers and
# verdicts.
#
#   tools/studies/ratchet.sh           a telling subset at the paper's length
#   tools/studies/ratchet.sh --quick   everything, coarse: about two minutes
#   tools/studies/ratchet.sh --full    the paper's whole campaign, and twice its statistics for the
#                                      tilt curve
#   tools/studies/ratchet.sh --errors  instead: how far time step and noise interval can be raised,
#                                      and what it buys
#   tools/studies/ratchet.sh --draw    runs nothing, draws what is there; without results from
#                                      docs/studies/data alone
#   tools/studies/ratchet.sh --help    all options: -o DIR, -j N, --only NAME, --keep DIR,
#                                      --program FILE
# Results go to build/reproduce. It may be stopped at any time: the same command goes on, and the
# page shows what is there, with a list of what is missing, and what it took in all calls.
# docs/studies/reproduce.md says more.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)

. "$root/tools/prepare.sh"
PYTHONPATH="$root/tools/studies${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -B -m ratchet "$@"
