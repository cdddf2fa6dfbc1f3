#!/usr/bin/env bash
# test_script_options.sh: --help, -h, --draw and --no-install of the scripts of tools/ install, build and run nothing. They
# run in a copy of tools/ without a build, with apt-get and the like in front of the path that note that they were called;
# once with the python3 of this machine, once with one that has no modules.
set -euo pipefail
source_dir=${SLIPDISK_SOURCE_DIR:-$(cd "$(dirname "$0")/../.." && pwd)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/stubs" "$work/tree"
cp -r "$source_dir/tools" "$source_dir/inputs" "$work/tree"

for name in apt-get apt sudo cmake ctest ninja make git gcc cc clang-format clang-format-14 clang-tidy clang-tidy-14 slipdisk srun \
  lmp liggghts; do
  printf '#!/bin/sh\necho "%s $*" >>"%s/called"\nexit 97\n' "$name" "$work" >"$work/stubs/$name"
  chmod +x "$work/stubs/$name"
done

failures=0
# quiet WANTED-STATUS WORDS-IN-OUTPUT COMMAND...: this status ("any": no matter which), these words, and no stub called
quiet() {
  local wanted=$1 words=$2 status=0
  shift 2
  rm -f "$work/called"
  (cd "$work" && PATH=$work/stubs:$PATH timeout 600 "$@") >"$work/out" 2>&1 </dev/null || status=$?
  local good=yes
  if [ "$wanted" != any ] && [ "$wanted" != "$status" ]; then good=no; fi
  [ -z "$words" ] || grep -qi -- "$words" "$work/out" || good=no
  if [ -e "$work/called" ]; then good=no; fi
  if [ $good = yes ]; then return; fi
  failures=$((failures + 1))
  echo "FAILED: $*: status $status, expected $wanted and \"$words\"; called:"
  cat "$work/called" 2>/dev/null || true
  tail -n 5 "$work/out"
}

scripts=("$work"/tree/tools/{,studies/}*.sh "$work"/tree/tools/packaging/{deb,tag}.sh "$work/tree/tools/cluster/sweep.sbatch")
[ ${#scripts[@]} -ge 9 ] || { echo "FAILED: scripts are missing" >&2; exit 1; }
for modules in with without; do
  if [ $modules = without ]; then export PYTHONHOME=$work/nowhere; fi
  for script in "${scripts[@]}"; do
    name=$(basename "$script")
    [ "$name" != prepare.sh ] || continue # which is sourced by others
    quiet 0 "$name" bash "$script" --help
    [ $modules = with ] || quiet 0 "$name" bash "$script" -h
  done
  for name in studies/ratchet studies/packings studies/rheology compare_peers; do
    quiet any "" bash "$work/tree/tools/$name.sh" --draw
  done
  quiet any "" bash "$work/tree/tools/compare_peers.sh" --no-install --sizes 1e3
done
quiet 2 "no python3 with" bash "$work/tree/tools/studies/ratchet.sh" --draw
quiet 2 "tools/quickstart.sh" bash "$work/tree/tools/quickstart.sh" --unknown
quiet 2 "tools/install_deps.sh" bash "$work/tree/tools/install_deps.sh" --unknown
unset PYTHONHOME
# what each option adds, on a machine that has nothing and where sudo is called
printf '#!/bin/sh\nexit 1\n' >"$work/stubs/dpkg-query"
printf '#!/bin/sh\necho 1000\n' >"$work/stubs/id"
chmod +x "$work/stubs/dpkg-query" "$work/stubs/id"
for pair in --tests:libcmocka-dev --tests:python3-sphinx --tests:lintian --docs:python3-sphinx --deb:lintian --mpi:libopenmpi-dev; do
  PATH=$work/stubs:$PATH bash "$work/tree/tools/install_deps.sh" "${pair%%:*}" --mpi >"$work/out" 2>&1 || true
  grep -q "^Packages to install:.* libgsl-dev .*${pair#*:}\b.*openmpi-bin" "$work/out" ||
    { failures=$((failures + 1)); echo "FAILED: install_deps.sh ${pair%%:*}"; cat "$work/out"; }
done
# another apt holds a lock three times, then no more
cat >"$work/stubs/sudo" <<EOF
#!/bin/sh
echo >>"$work/tries"
[ "\$(wc -l <"$work/tries")" -gt 3 ] && exit 0
echo "E: Could not get lock /var/lib/apt/lists/lock" >&2
exit 100
EOF
PATH=$work/stubs:$PATH SLIPDISK_APT_WAIT=0 bash "$work/tree/tools/install_deps.sh" >"$work/out" 2>&1 &&
  [ "$(wc -l <"$work/tries")" = 5 ] && [ "$(grep -c 'Another apt is at work' "$work/out")" = 1 ] ||
  { failures=$((failures + 1)); echo "FAILED: install_deps.sh does not wait for another apt"; cat "$work/out"; }
rm "$work/stubs/dpkg-query" "$work/stubs/id" "$work/stubs/sudo"
quiet 0 "deck_docs.py" python3 "$work/tree/tools/deck_docs.py" --help

# the stubs are what a script would call
rm -f "$work/called"
(cd "$work" && PATH=$work/stubs:$PATH bash "$work/tree/tools/quickstart.sh" --no-install) >/dev/null 2>&1 || true
grep -q '^cmake' "$work/called" || { echo "FAILED: the stubs do not stand in front" >&2; exit 1; }
! grep -q '^apt-get' "$work/called" || { echo "FAILED: quickstart.sh --no-install installs" >&2; exit 1; }

[ $failures = 0 ] || { echo "$failures FAILED"; exit 1; }
echo "ok"
