#!/usr/bin/env bash
# mu(I) and phi(I) of disks in simple shear: runs inputs/shear/rheology.cfg, compares it with
# da Cruz et al.
#
#   tools/studies/rheology.sh                    ten inertial numbers from 1e-4 to 0.3: half an hour
#                                                of one core
#   tools/studies/rheology.sh --points 0.1,0.3   only these
#   tools/studies/rheology.sh --quick            512 disks and little strain: a minute, and large
#                                                errors
#   tools/studies/rheology.sh --cases            what mu(0.1) depends on: one thing changed at a
#                                                time, half an hour of one core
#   tools/studies/rheology.sh --series           with the published stiffness and restitution, and slow
#                                                flow for long: a quarter of an hour of one core
#   tools/studies/rheology.sh --draw             runs nothing; without results from docs/studies/data
#                                                alone
#   tools/studies/rheology.sh --help             all options: -o DIR, --threads N, --keep DIR, ...
# Results go to build/rheology; what is finished is not run again. `--keep docs/studies` renews
# docs/studies/rheology.md, its numbers and its figures. Figures look as in tools/studies/ratchet.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)

. "$root/tools/prepare.sh"
PYTHONPATH="$root/tools/studies${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -B -m rheology "$@"
