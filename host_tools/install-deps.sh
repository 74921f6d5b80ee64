#!/bin/sh
# Installs what is missing and nothing else. Usage: install-deps.sh "DEBIAN PACKAGES" VENV REQUIREMENTS
# System packages: through apt, as root or with sudo; elsewhere they are named and the script fails.
# Python packages: pinned, into VENV; the comanip package itself is linked there, not copied.
set -eu
packages=$1 venv=$2 requirements=$3
here=$(cd "$(dirname "$0")" && pwd)

system_is_complete() {
    command -v gcc >/dev/null && command -v python3 >/dev/null &&
        printf '#include <ode/ode.h>\n' | gcc -E - >/dev/null 2>&1 &&
        python3 -c 'import ensurepip, sys, sysconfig, pathlib
sys.exit(sys.version_info < (3, 11) or not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' 2>/dev/null
}

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

if ! system_is_complete; then
    if ! command -v apt-get >/dev/null || { [ "$(id -u)" != 0 ] && ! command -v sudo >/dev/null; }; then
        echo "comanip: missing system packages, and this is no machine where I may run apt-get." >&2
        echo "Please install (Debian's names; Python 3.11 or newer): $packages" >&2
        exit 1
    fi
    echo "comanip: installing system packages: $packages"
    as_root apt-get update -qq
    # shellcheck disable=SC2086
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null
    system_is_complete || { echo "comanip: still incomplete after installing: $packages (Python 3.11 or newer?)" >&2; exit 1; }
fi

if ! cmp -s "$requirements" "$venv/.installed"; then
    echo "comanip: installing Python packages into $venv/"
    [ -x "$venv/bin/python" ] || python3 -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$requirements"
    site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    echo "$here" >"$site/comanip.pth"
    cp "$requirements" "$venv/.installed"
fi
touch "$venv/.installed" # newer than the requirements, so that make is content
