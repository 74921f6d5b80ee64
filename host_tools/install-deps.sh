#!/bin/sh
# Installs only what is missing. Usage: install-deps.sh "DEBIAN PACKAGES" VENV REQUIREMENTS
# System packages are installed through apt, as root or with sudo. Without apt, the script lists them and fails.
# Python packages are installed into VENV in the pinned versions, and the packages of this repository are linked there.
set -eu
packages=$1 venv=$2 requirements=$3
here=$(cd "$(dirname "$0")" && pwd)

fail() {
    printf 'comanip: %s\n' "$@" >&2
    exit 1
}

system_is_complete() {
    command -v gcc >/dev/null && command -v candump >/dev/null && command -v python3 >/dev/null &&
        printf '#include <%s>\n' ode/ode.h ccd/ccd.h yaml.h | gcc -E - >/dev/null 2>&1 &&
        python3 -c 'import ensurepip, sys, sysconfig, pathlib
header = pathlib.Path(sysconfig.get_path("include"), "Python.h")
sys.exit(sys.version_info < (3, 11) or not header.exists())' 2>/dev/null
}

install_system_packages() {
    if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
    if ! command -v apt-get >/dev/null; then
        fail "missing system packages, and this machine has no apt-get." \
            "Please install the equivalents of these Debian packages, then try again: $packages (Python 3.11 or newer)"
    fi
    if [ -n "$sudo" ] && ! command -v sudo >/dev/null; then
        fail "missing system packages, and you are not root and have no sudo. Ask an administrator to run:" \
            "    apt-get install $packages" "then try again."
    fi
    echo "comanip: installing system packages: $packages"
    $sudo apt-get update -qq
    # shellcheck disable=SC2086
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null
    system_is_complete || fail "packages are still missing after installing $packages: is Python older than 3.11?"
}

# True if VENV is complete, was created for this clone, and was made from these requirements. If the clone was moved or
# copied, the scripts in VENV contain the paths of the old folder.
venv_is_complete() {
    [ "$(cat "$venv/.folder" 2>/dev/null)" = "$here" ] && cmp -s "$requirements" "$venv/.installed"
}

install_python_packages() {
    echo "comanip: installing Python packages into $venv/ (needs the network, once)"
    rm -f "$venv/.installed" "$venv/.installed-tests"
    [ ! -L "$venv" ] || rm "$venv" # --clear would follow the link and empty the environment of another folder
    python3 -m venv --clear "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$requirements" ||
        fail "the Python packages could not be installed: is PyPI reachable (proxy, PIP_INDEX_URL)?"
    printf '#!%s\nfrom comanip.__main__ import main\n\nmain()\n' "$(cd "$venv" && pwd)/bin/python" >"$venv/bin/comanip"
    chmod +x "$venv/bin/comanip"
    echo "$here" >"$venv/.folder"
    cp "$requirements" "$venv/.installed" # last, so that an interrupted run starts over
}

# Makes comanip and comanip_dev importable in VENV, through a .pth file. Runs every time, even if VENV is complete.
link_packages() {
    for link in "$venv"/lib/python3*/site-packages; do
        link=$link/comanip.pth
        printf '%s\n' "$here" "$here/development" | cmp -s - "$link" ||
            printf '%s\n' "$here" "$here/development" >"$link"
    done
}

system_is_complete || install_system_packages
venv_is_complete || install_python_packages
link_packages
