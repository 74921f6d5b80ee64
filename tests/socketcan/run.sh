#!/bin/sh
# Tests firmware and plant on the kernel's SocketCAN, even if this machine's kernel has none: boots user-mode Linux with
# this machine's root file system and runs init.sh there. Usage: tests/socketcan/run.sh PYTHON [arguments for pytest]
# Exit status: 0 if the tests passed or were skipped (the reason is printed); 1 if they failed, or were skipped although
# REQUIRED=1.
set -eu
repository=$(cd "$(dirname "$0")/../.." && pwd)
packages="user-mode-linux busybox-static iproute2 can-utils"
boot_s=600

skip() {
    echo "make test-socketcan: SKIPPED: $1"
    [ "${REQUIRED:-0}" != 1 ]
    exit # with the status of the test above
}

is_complete() {
    command -v linux.uml >/dev/null && command -v busybox >/dev/null && command -v ip >/dev/null &&
        command -v candump >/dev/null
}

if ! is_complete; then
    if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi
    command -v apt-get >/dev/null || skip "no apt-get to install what is missing of: $packages"
    [ -z "$sudo" ] || command -v sudo >/dev/null || skip "no root or sudo to install what is missing of: $packages"
    echo "comanip: installing $packages"
    $sudo apt-get update -qq
    # shellcheck disable=SC2086
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null ||
        skip "apt-get cannot install $packages on $(dpkg --print-architecture); user-mode-linux is for amd64 and i386"
fi

# The folder's path is part of the kernel's command line, so it must not contain spaces.
folder=$(mktemp -d /tmp/comanip-socketcan.XXXXXX)
trap 'rm -rf "$folder"' EXIT
ln -s "$repository" "$folder/repository"
cp "$repository/tests/socketcan/init.sh" "$folder/init.sh"
printf '%s\n' "$@" >"$folder/arguments"

: >"$folder/console"
timeout "$boot_s" linux.uml mem=512M rootfstype=hostfs root=/dev/root rootflags=/ rw init="$folder/init.sh" \
    con=null con0=fd:0,fd:1 quiet </dev/null >"$folder/console" 2>&1 &
kernel=$!
tail -f -n +1 --pid=$kernel "$folder/console"
wait $kernel || true
[ -e "$folder/booted" ] || skip "user-mode Linux does not boot here: $(tail -n 1 "$folder/console")"
[ -e "$folder/status" ] || {
    echo "make test-socketcan: user-mode Linux ended before the tests, or was stopped after $boot_s s: see above" >&2
    exit 1
}
exit "$(cat "$folder/status")"
