#!/bin/sh
# Prints the traffic of the kernel interface BUS or, if there is no such interface, of the hub BUS. Does not start
# a bus.
# Usage: candump.sh WITH_CAN BUS [OPTION OF CANDUMP...]
set -eu
with_can=$1 bus=$2
shift 2
ARPHRD_CAN=280
if ! command -v candump >/dev/null; then
    echo "make candump: needs candump (Debian and Ubuntu: apt-get install can-utils)" >&2
    exit 1
fi
[ $# != 0 ] || set -- -ta
if [ "$(cat "/sys/class/net/$bus/type" 2>/dev/null)" = $ARPHRD_CAN ]; then
    echo "make candump: $bus is an interface of the kernel" >&2
    exec candump "$@" "$bus"
fi
hub=${COMANIP_HUB_DIR:-/tmp/comanip-hub-$(id -u)}/$bus
if [ ! -S "$hub" ]; then
    echo "make candump: the kernel has no CAN interface $bus, and no hub runs at $hub. Start one of:" >&2
    echo "    make sim CAN=hub REALTIME=1      the simulator, with a hub" >&2
    echo "    make hub CAN=$bus                a hub alone" >&2
    echo "    ip link add dev $bus type vcan; ip link set $bus mtu 72 up      as root, if the kernel has CAN" >&2
    exit 1
fi
echo "make candump: the kernel has no CAN interface $bus; showing the hub at $hub" >&2
exec "$with_can" candump "$@" "$bus"
