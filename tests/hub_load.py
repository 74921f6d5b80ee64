"""Loads a hub with RATE frames/s for SECONDS. Four listeners must receive every frame in order, and a listener that
never reads must be dropped; otherwise the exit status is 1. Usage: hub_load.py [--seconds N] [--rate N]."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import socket
import struct
import sys
import time

from hub import fd, running

LISTENERS = 4
TICK_S = 0.001
LONGEST_WAIT_S = 30.0


def listen(path: str, ready, results) -> None:
    """Counts frames until one is out of order or has a negative number, which marks the end."""
    client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    client.connect(path)
    client.settimeout(LONGEST_WAIT_S)
    ready.release()
    expected, latest_s = 0, 0.0
    try:
        while packet := client.recv(100):
            number, sent_s = struct.unpack_from("=qd", packet, 8)
            if number != expected:
                break
            latest_s = max(latest_s, time.monotonic() - sent_s)
            expected += 1
    except TimeoutError:
        pass
    results.put((expected, latest_s))


def send(client: socket.socket, rate: int, seconds: int) -> float:
    """Sends the frames. Returns how long that took, in s."""
    start_s, sent = time.monotonic(), 0
    while sent < rate * seconds:
        due = min(int((time.monotonic() - start_s) * rate), rate * seconds)
        while sent < due:
            client.send(fd(0x123, struct.pack("=qd", sent, time.monotonic()) + bytes(48)))
            sent += 1
        time.sleep(TICK_S)
    client.send(fd(0x123, struct.pack("=qd", -1, time.monotonic()) + bytes(48)))
    return time.monotonic() - start_s


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--rate", type=int, default=20_000)
    arguments = parser.parse_args()
    expected = arguments.seconds * arguments.rate
    with running() as hub:
        ready, results = multiprocessing.Semaphore(0), multiprocessing.Queue()
        listeners = [
            multiprocessing.Process(target=listen, args=(str(hub.path), ready, results)) for _ in range(LISTENERS)
        ]
        for listener in listeners:
            listener.start()
        for _ in listeners:
            ready.acquire()
        stalled, sender = hub.connect(), hub.connect()
        hub.wait_for_clients(LISTENERS + 2)
        took_s = send(sender, arguments.rate, arguments.seconds)
        got = [results.get(timeout=2 * LONGEST_WAIT_S) for _ in listeners]
        cpu_s = sum(int(part) for part in open(f"/proc/{hub.process.pid}/stat").read().split()[13:15]) / os.sysconf(
            "SC_CLK_TCK"
        )
        dropped = hub.stderr().count("is dropped: it reads too slowly")
        stalled.close()
    print(
        f"sent {expected} frames in {took_s:.2f} s ({expected / took_s:.0f}/s); the hub used {cpu_s:.1f} s of CPU time"
    )
    for count, latest_s in got:
        print(f"listener: {count} frames, {expected - count} lost, longest delay {1e3 * latest_s:.1f} ms")
    print(f"stalled listener: {'dropped' if dropped == 1 else f'{dropped} were dropped'}")
    return 0 if all(count == expected for count, _ in got) and dropped == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
