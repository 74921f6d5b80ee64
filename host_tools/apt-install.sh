#!/bin/sh
# Installs Debian packages. Usage: apt-install.sh "make TARGET" PACKAGE...
set -eu
who=$1
shift
if dpkg-query -W -f '${db:Status-Abbrev}\n' "$@" 2>/dev/null |
    awk '!/^ii/ { missing = 1 } END { exit missing || NR < '$#' }'; then
    exit 0
fi
if ! command -v apt-get >/dev/null; then
    echo "$who: no apt-get on this machine; install the equivalents of: $*" >&2
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    sudo=
elif command -v sudo >/dev/null; then
    sudo=sudo
else
    echo "$who: needs root or sudo. Ask an administrator to run: apt-get install $*" >&2
    exit 1
fi
echo "comanip: installing $*"
$sudo apt-get update -qq
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
