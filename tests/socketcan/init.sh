#!/bin/sh
# The first process in user-mode Linux. It loads the CAN modules, creates three virtual buses, one of them without FD,
# and runs the tests. The root file system is that of the host.
folder=$(dirname "$0")
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME="$folder" LANG=C.UTF-8
{
    mount -t proc proc /proc
    mount -t sysfs sys /sys
    mount -t tmpfs tmpfs /run
    mount -t devpts devpts /dev/pts
} 2>/dev/null
touch "$folder/booted"
modules=/usr/lib/uml/modules/$(uname -r)/kernel
set -e
trap 'busybox poweroff -f' EXIT
for module in drivers/net/can/dev/can-dev net/can/can net/can/can-raw drivers/net/can/vcan; do
    busybox insmod "$modules/$module.ko"
done
ip link set lo up
echo 16777216 >/proc/sys/net/core/rmem_default # large enough that listeners lose no frames on a busy host
for bus in vcan0 vcan1; do
    ip link add dev $bus type vcan
    ip link set $bus mtu 72 txqueuelen 1000 up
done
ip link add dev classic0 type vcan
ip link set classic0 mtu 16 up
echo "user-mode Linux $(uname -r): vcan0, vcan1, classic0"
cd "$folder/repository"
export COMANIP_TEST_CAN=vcan0 COMANIP_TEST_SLOW=10
status=0
tr '\n' '\0' <"$folder/arguments" | xargs -0 sh -c \
    'python=$1; shift; exec "$python" -m pytest -p no:cacheprovider tests/socketcan/vcan_tests.py \
        tests/test_two_processes.py::test_firmware_paused tests/test_two_processes.py::test_plant_paused \
        tests/test_two_processes.py::test_firmware_killed_and_started_again \
        tests/test_two_processes.py::test_plant_killed_and_started_again "$@"' sh || status=1
echo $status >"$folder/status"
