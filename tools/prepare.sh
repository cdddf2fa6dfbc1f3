# Prepares compare_peers.sh and the commands of tools/studies: sets $python to a python3 with their
# packages, and builds the program. To be sourced, with the root of the source tree in $root. With
# --help, --draw or --no-install nothing is installed or built.

help=no passive=no named=no
for word in "$@"; do
  case "$word" in
    -h | --help) help=yes passive=yes ;;
    --draw | --no-install) passive=yes ;;
    --program | --program=*) named=yes ;;
  esac
done

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
  if [ $help = yes ]; then
    sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
    exit 0
  elif [ $passive = yes ]; then
    echo "no python3 with h5py, numpy and matplotlib (tools/install_deps.sh --tests)" >&2
    exit 2
  fi
  "$root/tools/install_deps.sh" --tests
  python=$(find_python) || { echo "no python3 with h5py, numpy and matplotlib" >&2; exit 2; }
fi

# The program is built unless it is there already or another one is named.
if [ ! -x "$root/build/release/slipdisk" ] && [ $named = no ] && [ $passive = no ]; then
  "$root/tools/install_deps.sh"
  cmake -S "$root" -B "$root/build/release" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null
  cmake --build "$root/build/release" --target slipdisk_program
fi
