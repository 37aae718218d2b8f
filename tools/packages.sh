# Sourced by tools/check and tools/demo: packages of Debian and the choice of Python.

# install_packages <name>…: those that are missing, with apt-get, as root or by sudo.
install_packages() {
  local missing=() package
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    echo "== apt-get is missing here. Needed, by their Debian names: $*"
    echo "   Going on with what CMake finds."
    return
  fi
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
      missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  local become=()
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "== Neither root nor sudo. Please install: ${missing[*]}"
      echo "   Going on with what CMake finds."
      return
    fi
    become=(sudo)
  fi
  echo "== Installing with apt-get: ${missing[*]}"
  local install=("${become[@]}" env DEBIAN_FRONTEND=noninteractive
    apt-get install -y -qq --no-install-recommends -o=Dpkg::Use-Pty=0 "${missing[@]}")
  "${install[@]}" >/dev/null 2>&1 && return
  echo "== Updating apt-get's lists first"
  "${become[@]}" apt-get update -qq
  "${install[@]}" >/dev/null
}

# Warnings are errors with the compiler that they were cleared with; a newer one may know more.
warnings_as_errors() {
  [ "$(${CXX:-g++} -dumpversion 2>/dev/null | cut -d. -f1)" = 12 ] && echo ON || echo OFF
}

# Options of every configuration: a compiler cache where there is one. It does not know precompiled headers.
compiler_cache() {
  if command -v ccache >/dev/null; then
    echo "-DCMAKE_CXX_COMPILER_LAUNCHER=$PWD/tools/ccache" -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON
  fi
}

# The part on several processes, where PETSc and MPI are installed.
petsc() {
  if pkg-config --exists PETSc 2>/dev/null && command -v mpirun >/dev/null; then
    echo -DQUOIN_BUILD_PETSC=ON
  fi
}

# The Python module `quoin`, where what it needs is installed.
python_packages="pybind11-dev python3-dev python3-numpy python3-setuptools python3-wheel python3-venv"
python_module() {
  if dpkg-query -W pybind11-dev python3-dev python3-numpy >/dev/null 2>&1; then
    echo -DQUOIN_BUILD_PYTHON=ON
  fi
}

# The first Python that has what the pictures need; it may not be the first in PATH.
python_with_matplotlib() {
  local python
  for python in python3 /usr/bin/python3; do
    if "$python" -c 'import matplotlib' 2>/dev/null; then
      echo "$python"
      return
    fi
  done
  echo "no python3 with matplotlib" >&2
  return 1
}
