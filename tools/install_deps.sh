#!/usr/bin/env bash
# Installs what slipdisk needs on Debian or Ubuntu, and only what is missing.
#   tools/install_deps.sh           to build and run
#   tools/install_deps.sh --plot    also what plots, films and Python need
#   tools/install_deps.sh --pip     also what pip install . and films need
#   tools/install_deps.sh --tests   also what the tests, the formatter and the linter need; --docs is part of it
#   tools/install_deps.sh --docs    also what makes the documentation site
#   tools/install_deps.sh --deb     also what makes and checks the .deb
#   tools/install_deps.sh --mpi     also Open MPI and Zoltan, for builds with -DSLIPDISK_MPI=ON
#   tools/install_deps.sh --arm     also the cross compiler for aarch64 and qemu (tools/arm.sh)
#   tools/install_deps.sh --play    also what compiles the engine for browsers (tools/play.sh)
# Several may be given. Needs root (or sudo) only when something is missing.
set -euo pipefail
case " $* " in
  *" -h "* | *" --help "*) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac

packages=(gcc libc6-dev make cmake ninja-build pkg-config
          libgsl-dev libhdf5-dev libconfig-dev libjansson-dev libmicrohttpd-dev libxxhash-dev zlib1g-dev)
site=(python3-sphinx python3-myst-parser python3-breathe doxygen furo python3-sphinx-copybutton libjs-katex fonts-katex
      node-normalize.css python3-numpy python3-h5py python3-matplotlib)
notebooks=(python3-pandas python3-xarray python3-tqdm python3-nbconvert python3-ipykernel)
deb=(dpkg-dev fakeroot lintian)
plot=(python3 python3-numpy python3-h5py python3-matplotlib ffmpeg)
tests=no
for option in "$@"; do
  case "$option" in
    --tests)
      tests=yes
      packages+=("${notebooks[@]}")
      packages+=(git binutils libcmocka-dev librandom123-dev clang clang-format-14 clang-tidy-14
                 python3-venv hdf5-tools parallel xxhash
                 ccache gcovr mypy
                 chromium chromium-driver python3-selenium python3-mdanalysis python3-vtk9 python3-ase lammps
                 poppler-utils mandoc mmdebstrap "${site[@]}" "${deb[@]}" "${plot[@]}") ;;
    --pip) packages+=(python3 python3-venv ffmpeg) ;;
    --plot) packages+=("${plot[@]}") ;;
    --docs) packages+=("${site[@]}") ;;
    --deb) packages+=("${deb[@]}") ;;
    --mpi) packages+=(libopenmpi-dev openmpi-bin libtrilinos-zoltan-dev) ;;
    --arm) packages+=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user python3 python3-numpy python3-h5py) ;;
    --play) packages+=(emscripten node-acorn nodejs python3) ;;
    *) "$0" --help >&2; exit 2 ;;
  esac
done

if ! command -v dpkg-query >/dev/null; then
  echo "This is not Debian or Ubuntu. Install the equivalents of these packages yourself:" >&2
  echo "  ${packages[*]}" >&2
  # What is already there may be enough: CMake says so if it is not.
  exit 0
fi

installed() {
  dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed
}

# clang's sanitizers are in a package named after its version.
clang_runtime() {
  local version
  version=$(LC_ALL=C apt-cache depends clang 2>/dev/null | sed -n 's/.*Depends: clang-\([0-9][0-9]*\).*/\1/p' | head -n 1)
  echo "libclang-rt-${version:-14}-dev"
}

find_missing() {
  missing=()
  local package
  for package in "${packages[@]}"; do
    # pkgconf replaces pkg-config: the command counts.
    if [ "$package" = pkg-config ] && command -v pkg-config >/dev/null; then continue; fi
    installed "$package" || missing+=("$package")
  done
  if [ "$tests" = yes ]; then
    local runtime
    runtime=$(clang_runtime)
    installed "$runtime" || missing+=("$runtime")
  fi
}

find_missing
if [ ${#missing[@]} -eq 0 ]; then
  echo "Packages: all ${#packages[@]} are installed."
  exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "These packages are missing, and neither root nor sudo is at hand to install them:" >&2
    echo "  ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

# Waits while another apt is at work: apt-get itself waits for dpkg's lock, but not for that of the package lists.
apt() {
  local wait said
  said=$(mktemp)
  for wait in $(seq 240); do
    # env: sudo drops the variables otherwise.
    if { "${as_root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive \
        apt-get -o DPkg::Lock::Timeout=1200 "$@" 2>&1 >&3 | tee "$said" >&2; } 3>&1; then
      rm -f "$said"
      return
    fi
    grep -q 'Could not get lock' "$said" || break
    if [ "$wait" = 1 ]; then echo "Another apt is at work: waiting for it"; fi
    sleep "${SLIPDISK_APT_WAIT:-5}"
  done
  rm -f "$said"
  return 1
}

echo "Packages to install: ${missing[*]}"
apt update -q
find_missing # the name of clang's runtime is known for sure only now
if ! apt install -q -y --no-install-recommends "${missing[@]}"; then
  echo "These packages could not be installed: ${missing[*]}" >&2
  exit 1
fi
