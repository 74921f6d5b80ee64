"""Processor in the loop: runs a firmware image in QEMU, in lockstep with the simulator over a serial line.

``python -m comanip_dev.images.pil "EMULATOR" IMAGE.elf PROGRAM [options of comanip-sim]`` (``make pil``). EMULATOR is
the command that emulates the board. Exit status: that of the simulator, or 2 for a usage error or a missing emulator.
QEMU executes the processor's instructions but does not model cycles or times.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

# Each instruction takes 2 ns of the emulated time, which stops while the board waits for the simulator. The watchdog
# therefore does not expire on a busy machine.
VIRTUAL_TIME = ["-icount", "shift=1,sleep=off"]
START_S = 10
EXIT_WRONG_USE = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT
EXIT_TERMINATED = 143  # 128 + SIGTERM


def complain(text: str) -> int:
    print(f"comanip_dev.images.pil: {text}", file=sys.stderr)
    return EXIT_WRONG_USE


def run(program: list[str]) -> int:
    """Runs the program and returns its exit status. Terminates the program when this process is interrupted or
    terminated."""
    process = subprocess.Popen(program)
    try:
        return process.wait()
    finally:
        process.terminate()
        process.wait()


def main(argv: Sequence[str]) -> int:
    if len(argv) < 3 or not argv[0].split():
        return complain("expected EMULATOR IMAGE PROGRAM [options]: see `make pil`")
    machine, (image, program, *options) = argv[0].split(), argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        serial = Path(folder) / "serial"
        command = [*machine, *VIRTUAL_TIME, "-display", "none", "-monitor", "none", "-kernel", image,
                   "-serial", f"unix:{serial},server=on,wait=on"]  # fmt: skip
        try:
            emulator = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
            )
        except FileNotFoundError:
            return complain(f"{machine[0]} is not installed: make target-deps")
        try:
            deadline_s = time.monotonic() + START_S
            while not serial.exists() and emulator.poll() is None and time.monotonic() < deadline_s:
                time.sleep(0.02)
            if emulator.poll() is not None:
                return complain(f"{machine[0]} ended: {emulator.stderr.read().strip()}")
            if "--quiet" not in options:
                print(f"{image} in {' '.join(machine)}", flush=True)
            status = run([program, "--serial", str(serial), *options])
            if emulator.poll() is not None:
                print(f"comanip_dev.images.pil: {machine[0]} ended: {emulator.stderr.read().strip()}", file=sys.stderr)
            return status
        except KeyboardInterrupt:
            return EXIT_INTERRUPTED
        finally:
            emulator.kill()
            emulator.wait()


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(EXIT_TERMINATED))
    sys.exit(main(sys.argv[1:]))
