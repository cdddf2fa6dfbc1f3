#!/usr/bin/env bash
# What the launcher makes of ranks that give up or die, and what a rank makes of a launcher that is not its own.
set -euo pipefail
program=${SLIPDISK_BUILD_DIR:?}/tests/test_comm
read -ra mpiexec <<<"${SLIPDISK_MPIEXEC:?}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "$1" >&2
  cat "$work/log" >&2
  exit 1
}

# status WANTED WHAT COMMAND...: a rank that waits for ever would meet the limit (status 124).
status() {
  local wanted=$1 what=$2 found=0
  shift 2
  timeout 600 "$@" >"$work/log" 2>&1 || found=$?
  [ "$found" -eq "$wanted" ] || fail "$what: exit status $found, expected $wanted"
  echo "$what: ok"
}

status 4 "comm_abort ends all ranks" "${mpiexec[@]}" -n 3 "$program" 3 abort
status 4 "comm_fail tells why" "${mpiexec[@]}" -n 3 "$program" 3 fail
grep -qx 'rank 2: no memory' "$work/log" || fail "comm_fail does not tell why"
status 137 "a rank that is killed ends all ranks" "${mpiexec[@]}" -n 3 "$program" 3 die
status 2 "ranks that do not find each other" env PMI_SIZE=3 "$program"
grep -q '^error: PMI_SIZE = 3: .*another MPI' "$work/log" || fail "no message"
