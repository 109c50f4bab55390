# Shared by run-demo and run-tests: packages of Debian 12 and Ubuntu 24.04, and building with a preset.

packages=(g++ cmake ninja-build pkg-config ccache
          libembree-dev libtbb-dev libeigen3-dev libbullet-dev libbullet-extras-dev libfcl-dev
          libcli11-dev libfmt-dev nlohmann-json3-dev libopenmesh-dev libxtensor-dev libpng-dev zlib1g-dev libjs-three libjs-chart.js libmd4c-dev libmd4c-html0-dev libboost-dev libcgal-dev libcgal-demo
          libopenmpi-dev openmpi-bin libgmp-dev libgtest-dev libgmock-dev libbenchmark-dev
          python3-dev python3-venv python3-matplotlib libx11-6)

# Arguments of cmake when build() configures.
configure=()

# Presets and the tests of packages compile the same files with the same flags more than once.
export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
export CCACHE_DIR=$PWD/build/ccache

# Installs the packages that are not installed yet, with sudo if need be; says nothing if there are none.
install_packages() {
    local missing=()
    for package in "$@"; do
        dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
    done
    ((${#missing[@]})) || return 0
    echo "installing ${missing[*]}"
    local as_root=()
    ((EUID == 0)) || as_root=(sudo)
    "${as_root[@]}" apt-get update -q >/dev/null
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -yq --no-install-recommends "${missing[@]}" >/dev/null
}

# python_environment FOLDER [PACKAGES...]: a Python environment with packages of PyPI.
python_environment() {
    local folder=$1
    shift
    [[ -x $folder/bin/python ]] || python3 -m venv "$folder"
    "$folder/bin/python" -m pip install -q --disable-pip-version-check "$@"
}

# build PRESET [cmake --build arguments]: configures when there is no build yet, then builds what changed. What is in the
# array `configure` goes to cmake.
build() {
    local preset=$1
    shift
    [[ -f build/$preset/build.ninja ]] || cmake --preset "$preset" "${configure[@]}" >"/tmp/pierce-configure-$preset.$$" 2>&1 ||
        { cat "/tmp/pierce-configure-$preset.$$"; return 1; }
    rm -f "/tmp/pierce-configure-$preset.$$"
    cmake --build --preset "$preset" "$@" >"build/$preset/build.log" 2>&1 || { cat "build/$preset/build.log"; return 1; }
}
