# What reproduce.sh and packings.sh need before they begin: a python3 in $python and the program. To be sourced, with
# the root of the source tree in $root.

# A python3 with h5py, numpy and matplotlib: the first one on the path need not be the system's.
find_python() {
  local candidate
  for candidate in python3 /usr/bin/python3 /usr/local/bin/python3; do
    if "$candidate" -c "import h5py, numpy, matplotlib" 2>/dev/null; then
      echo "$candidate"
      return
    fi
  done
  return 1
}

if ! python=$(find_python); then
  "$root/tools/install_deps.sh" --tests
  python=$(find_python) || { echo "no python3 with h5py, numpy and matplotlib" >&2; exit 2; }
fi

# The program is built unless it is there already or another one is named.
if [ ! -x "$root/build/release/slipdisk" ] && [[ " $* " != *" --program"* && " $* " != *" --help "* ]]; then
  "$root/tools/install_deps.sh"
  cmake -S "$root" -B "$root/build/release" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null
  cmake --build "$root/build/release" --target slipdisk_program
fi
