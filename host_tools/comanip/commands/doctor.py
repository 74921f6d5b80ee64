"""``comanip doctor``: lists what is installed on this machine, and how to install what is missing."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import shutil
import socket
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import typer
from rich.table import Table
from rich.text import Text

from comanip.bus.live import BusAddress
from comanip.commands.options import console, examples
from comanip.commands.sim import find_simulator
from comanip.errors import ToolError

HELP = examples("comanip doctor")
PACKAGES = ("cantools", "python-can", "numpy", "typer", "rich", "mcap", "matplotlib")
PYTHON_LEAST = (3, 11)


@dataclass(frozen=True)
class Finding:
    """One line of the report. needed: True if every command requires the thing, False if only some commands do."""

    what: str
    found: str | None  # None: missing
    remedy: str
    needed: bool = False


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    return Finding(
        "Python",
        version if sys.version_info >= PYTHON_LEAST else None,
        f"install Python 3.11 or newer (this is {version})",
        True,
    )


def _package(name: str) -> Finding:
    try:
        found = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        found = None
    return Finding(
        name,
        found,
        f"`make build` in the repository, or pip install {name}",
        name in ("cantools", "python-can", "numpy"),
    )


def _core() -> Finding:
    try:
        from comanip import native

        _, lib = native.load()
        found = f"build hash {lib.replay_build_hash():016x}"
    except ToolError:
        found = None
    return Finding("compiled core", found, "`make build` in the repository (replay and comanip.core need it)")


def _simulator() -> Finding:
    found = find_simulator()
    return Finding("simulator", str(found) if found else None, "`make build` in the repository (comanip sim needs it)")


def _kernel_can() -> Finding:
    try:
        socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
        found = "socket(PF_CAN) works"
    except (OSError, AttributeError):
        found = None
    return Finding("CAN in the kernel", found, "modprobe can-raw; if that is not possible, use a hub: `make hub`")


def _interfaces() -> Finding:
    names = [  # 280 is ARPHRD_CAN
        folder.name for folder in sorted(Path("/sys/class/net").glob("*"))
        if (folder / "type").is_file() and (folder / "type").read_text().strip() == "280"
    ]  # fmt: skip
    return Finding(
        "CAN interfaces", ", ".join(names) or None, "ip link add vcan0 type vcan; ip link set vcan0 mtu 72 up"
    )


def _hub() -> Finding:
    folder = Path(os.environ.get("COMANIP_HUB_DIR") or f"/tmp/comanip-hub-{os.getuid()}")
    names = sorted(path.name for path in folder.glob("*") if path.is_socket()) if folder.is_dir() else []
    return Finding("hub", f"{folder}: {', '.join(names)}" if names else None, "`make hub` in the repository starts one")


def _socketcand() -> Finding:
    try:
        default = BusAddress()
        socket.create_connection((default.host, default.port), timeout=0.3).close()
        found = f"{default.host}:{default.port}"
    except OSError:
        found = None
    return Finding("socketcand", found, "a hub provides it: `make hub` (for -i socketcand)")


def _program(name: str, package: str, purpose: str) -> Callable[[], Finding]:
    return lambda: Finding(name, shutil.which(name), f"apt-get install {package} ({purpose})")


CHECKS: tuple[Callable[[], Finding], ...] = (
    _python,
    *(lambda name=name: _package(name) for name in PACKAGES),
    _core, _simulator, _kernel_can, _interfaces, _hub, _socketcand,
    _program("gcc", "gcc libc6-dev", "builds the simulator and the core"),
    _program("make", "make", "runs the build"),
    _program("clang", "clang", "make check"),
    _program("arm-none-eabi-gcc", "gcc-arm-none-eabi", "make target; or: make target-deps"),
    _program("riscv64-unknown-elf-gcc", "gcc-riscv64-unknown-elf", "make target; or: make target-deps"),
    _program("candump", "can-utils", "prints the traffic of a bus"),
)  # fmt: skip


def findings() -> list[Finding]:
    return [check() for check in CHECKS]


def doctor() -> None:
    """Show what is installed, which buses this machine has, and how to install what is missing.

    Exit status: 0, or 1 if something is missing that every command needs.
    """
    table = Table("", "what", "found, or remedy", box=None, pad_edge=False)
    found = findings()
    for finding in found:
        mark = (
            Text("ok", "green")
            if finding.found
            else Text("MISSING" if finding.needed else "none", "red" if finding.needed else "yellow")
        )
        table.add_row(mark, finding.what, Text(finding.found or finding.remedy))
    console().print(table)
    if any(finding.needed and not finding.found for finding in found):
        raise typer.Exit(1)
