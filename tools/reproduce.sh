#!/usr/bin/env bash
# Computes the figures of the paper anew and writes one HTML page with figures, numbers and verdicts.
#
#   tools/reproduce.sh           a telling subset at the paper's length
#   tools/reproduce.sh --quick   everything, coarse: about two minutes
#   tools/reproduce.sh --full    the paper's whole campaign, and twice its statistics for the tilt curve
#   tools/reproduce.sh --errors  instead: how far time step and noise interval can be raised, and what it buys
#   tools/reproduce.sh --draw    runs nothing, draws what is there; without results from docs/data alone
#   tools/reproduce.sh --help    all options: -o DIR, -j N, --only NAME, --keep DIR, --program FILE
# Results go to build/reproduce. It may be stopped at any time: the same command goes on, and the page shows what is
# there, with a list of what is missing, and what it took in all calls. docs/reproduce.md says more.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

. "$root/tools/report/prepare.sh"
PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -B -m report "$@"
